"""Views of a result: plots, pictures, and files for ParaView."""
