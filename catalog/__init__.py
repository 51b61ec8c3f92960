"""What exists on disk and where: datasets, parameters, cases, formats, and the store."""
