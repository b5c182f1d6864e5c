"""Documents made of blocks, as text, Markdown and HTML."""
