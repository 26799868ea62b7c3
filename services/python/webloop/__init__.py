"""webloop's controller in Python, as the paper's client was: blocking requests
on threads, with the standard library alone.

It does what `webloop serve controller` does and leaves the same files. When a
message is sent and with which u is decided in `end`; the crate `endpoint` is
the reference for it, and its vectors are this package's tests.

`webloop.control` runs a controller of one's own in the same loop,
`webloop.plant` steps a plant of one's own, and `webloop.results` reads the
folder of a campaign. They are imported when they are asked for: the built-in
client starts through here and needs none.

An old Python has to be able to read this file, as `__main__`: so no
annotations here. Those of what it offers are in `__init__.pyi`.
"""


def __getattr__(name):
    if name == "control":
        from webloop.own import control

        return control
    if name == "plant":
        from webloop.own_plant import plant

        return plant
    if name == "results":
        from importlib import import_module

        return import_module("webloop.results")
    raise AttributeError("module `webloop` has no `%s`" % name)
