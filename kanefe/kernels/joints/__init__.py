"""What the joints of links do in the sweeps: one file a kind, and the table of kinds (`by_kind`)."""
