"""Rest under loads, steady motion at given speeds, and the search for both."""
