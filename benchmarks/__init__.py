"""One file a question; each prints a table and, last, one JSON object."""
