"""Views of a result: pictures and files for ParaView. Each file is the door to one library."""
