"""webloop's controller in Python, as the paper's client was: blocking requests
on threads, with the standard library alone.

It does what `webloop serve controller` does and leaves the same files. When a
message is sent and with which u is decided in `end`; the crate `endpoint` is
the reference for it, and its vectors are this package's tests.
"""
