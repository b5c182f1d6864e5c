"""``kanefe new NAME``: a folder with a mesh source, a script that runs, and a page with the next steps."""
