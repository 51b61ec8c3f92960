"""One class a file format, each a pair of pure functions between an artefact and named bytes.

`encode(value) -> {file name: bytes}` and `decode({file name: bytes}) -> value`. The store alone
touches the disk: it writes, hashes and checks the bytes, so no format can leave half a file or
swallow a full disk, and what is decoded is what was checked.
"""
