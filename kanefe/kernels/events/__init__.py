"""Events in compiled code: search, what they change, and steps that end at them."""
