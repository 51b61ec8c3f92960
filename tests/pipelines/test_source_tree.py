"""What a function reaches: all that can change its result, and as little else as possible.

Small projects are written, one thing in them is edited, and the reach of `nodes.toy.main:main` must
or must not change.
"""

import ast
import textwrap
from pathlib import Path

import pytest

from pipelines.source_tree import Reach, SourceTree

TARGET = "nodes.toy.main:main"


class Sources:
    """A source tree in which tests write modules, given as name -> text, below nodes/toy."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.write({"__init__": "", "../__init__": ""})

    def write(self, files: dict[str, str]) -> None:
        for name, text in files.items():
            path = self.root / "nodes/toy" / (name if "." in Path(name).name else f"{name}.py")
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(textwrap.dedent(text).lstrip())

    def reach(self, target: str = TARGET) -> Reach:
        return SourceTree(self.root).reach(target)

    def counts(self, name: str, old: str, new: str) -> bool:
        """Return whether this edit changes what the function reaches; the edit stays."""
        before = self.reach()
        path = self.root / "nodes/toy" / (name if "." in name else f"{name}.py")
        text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new))
        return self.reach() != before


@pytest.fixture
def sources(tmp_path: Path) -> Sources:
    return Sources(tmp_path)


HELPER = """
    FACTOR = 2

    def used(x):
        return x * FACTOR

    def unused(x):
        return x + UNUSED

    UNUSED = 7

    class Thing:
        size = 3
        def grow(self):
            return self.size
    """
# How a function may come to call `used` (or to use `Thing`), and the edit that must then count.
WAYS = {
    "from import": "from nodes.toy.helper import used\ndef main(x):\n    return used(x)",
    "renamed": "from nodes.toy.helper import used as u\ndef main(x):\n    return u(x)",
    "module": "from nodes.toy import helper\ndef main(x):\n    return helper.used(x)",
    "module alias": "import nodes.toy.helper as h\ndef main(x):\n    return h.used(x)",
    "dotted module": "import nodes.toy.helper\ndef main(x):\n    return nodes.toy.helper.used(x)",
    "package": "from nodes import toy\ndef main(x):\n    return toy.helper.used(x)",
    "relative": "from .helper import used\ndef main(x):\n    return used(x)",
    "relative module": "from . import helper\ndef main(x):\n    return helper.used(x)",
    "two dots": "from ..toy.helper import used\ndef main(x):\n    return used(x)",
    "star": "from nodes.toy.helper import *\ndef main(x):\n    return used(x)",
    "relative star": "from .helper import *\ndef main(x):\n    return used(x)",
    "inside function": "def main(x):\n    from nodes.toy.helper import used\n    return used(x)",
    "module inside function": "def main(x):\n    from . import helper as h\n    return h.used(x)",
    "inner function": "from .helper import used\ndef main(x):\n"
    "    def inner(y):\n        return used(y)\n    return inner(x)",
    "lambda": "from .helper import used\ndef main(x):\n    return (lambda y: used(y))(x)",
    "comprehension": "from .helper import used\ndef main(x):\n    return [used(y) for y in [x]]",
    "f-string": "from .helper import used\ndef main(x):\n    return f'{used(x):>{used(1)}}'",
    "match": "from .helper import used\ndef main(x):\n    match x:\n        case 1:\n"
    "            return used(x)",
    "match guard": "from .helper import used\ndef main(x):\n    match x:\n"
    "        case n if used(n):\n            return n",
    "walrus": "from .helper import used\ndef main(x):\n    return (y := used(x))",
    "default": "from .helper import used\ndef main(x, y=used(1)):\n    return y",
    "keyword default": "from .helper import used\ndef main(x, *, y=used(1)):\n    return y",
    "decorator": "from .helper import used\n@used\ndef main(x):\n    return x",
    "constant": "from .helper import used\nTABLE = {'a': used}\ndef main(x):\n"
    "    return TABLE['a'](x)",
    "lambda in a table": "from .helper import used\nTABLE = {'a': lambda y: used(y)}\n"
    "def main(x):\n    return TABLE['a'](x)",
    "annotated constant": "from .helper import used\nN: int = used(1)\ndef main(x):\n    return N",
    "unpacked constant": "from .helper import used\nA, (B, *C) = used(1)\ndef main(x):\n"
    "    return C",
    "changed constant": "from .helper import used\nN = 1\nN += used(1)\ndef main(x):\n    return N",
    "changed entry": "from .helper import used\nN = {}\nN['a'] = used\ndef main(x):\n    return N",
    "changed attribute": "from .helper import used\ndef f(x): pass\nf.step = used\n"
    "def main(x):\n    return f.step(x)",
    "partial": "from functools import partial\nfrom .helper import used\nf = partial(used, 1)\n"
    "def main(x):\n    return f()",
    "alias": "from .helper import used\nf = g = used\ndef main(x):\n    return g(x)",
    "module as constant": "from . import helper\nOPS = helper\ndef main(x):\n"
    "    return OPS.used(x)",
    "module as value": "from . import helper\ndef main(x):\n"
    "    return getattr(helper, 'us' + 'ed')(x)",
    "module in a list": "from . import helper\nALL = [helper]\ndef main(x):\n"
    "    return ALL[0].used(x)",
    "module dictionary": "from . import helper\ndef main(x):\n"
    "    return helper.__dict__['used'](x)",
    "module variables": "from . import helper\ndef main(x):\n    return vars(helper)['used'](x)",
    "re-export": "from nodes.toy import shown\ndef main(x):\n    return shown(x)",
    "re-export as module": "from nodes import toy\ndef main(x):\n    return toy.shown(x)",
    "through another": "from nodes.toy.between import used\ndef main(x):\n    return used(x)",
    "through a star": "from nodes.toy.starry import used\ndef main(x):\n    return used(x)",
    "module of module": "from nodes.toy import between\ndef main(x):\n"
    "    return between.helper.used(x)",
    "base class": "from .between import Base\nclass Own(Base):\n    pass\n"
    "def main(x):\n    return Own().run(x)",
    "metaclass": "from .between import Base\nclass Own(metaclass=Base):\n    pass\n"
    "def main(x):\n    return Own",
    "class attribute": "from .helper import used\nclass Own:\n    f = used\n"
    "def main(x):\n    return Own.f",
    "class decorator": "from .helper import used\n@used\nclass Own:\n    pass\n"
    "def main(x):\n    return Own",
    "annotation": "from .between import Base\ndef main(x: Base):\n    return x.run(1)",
    "annotation inside": "from .between import Base\ndef main(x: list[Base | None]):\n    return x",
    "return annotation": "from .between import Base\ndef main(x) -> Base:\n    return x",
    "field annotation": "from .between import Base\nclass Own:\n    b: Base\n"
    "def main(x: Own):\n    return x.b.run(1)",
    "if at import": "from .helper import used\nif used(1):\n    N = 1\ndef main(x):\n    return x",
    "for at import": "from .helper import used\nN = []\nfor i in range(3):\n    N.append(used(i))\n"
    "def main(x):\n    return N",
    "call at import": "from .helper import used\nused(1)\ndef main(x):\n    return x",
    "with at import": "from .helper import used\nwith used(1) as N:\n    pass\ndef main(x):\n"
    "    return N",
    "conditional function": "import sys\nfrom .helper import used\nif sys.platform:\n"
    "    def f(x):\n        return used(x)\nelse:\n    f = None\ndef main(x):\n    return f(x)",
    "conditional import": "try:\n    from .helper import used\nexcept ImportError:\n"
    "    used = None\n"
    "def main(x):\n    return used(x)",
    "first of two imports": "try:\n    from .helper import used\nexcept ImportError:\n"
    "    from .other import used\ndef main(x):\n    return used(x)",
    "second of two imports": "try:\n    from .other import used\nexcept ImportError:\n"
    "    from .helper import used\ndef main(x):\n    return used(x)",
    "import over import": "from .helper import used\nfrom .other import used as other\n"
    "def main(x):\n    def a():\n        from .other import used\n        return used(x)\n"
    "    return used(x) + a()",
    "one name in two functions": "from .helper import used as f\nclass A:\n"
    "    def a(self):\n        return f(1)\n    def b(self):\n"
    "        from .other import used as f\n"
    "        return f(2)\ndef main(x):\n    return A().a()",
    "imported for its effect": "import nodes.toy.effect\ndef main(x):\n    return x",
    "imported for its effect inside": "def main(x):\n    from nodes.toy import effect\n"
    "    return x",
    "effect of what is imported": "from .chain import free\ndef main(x):\n    return free(x)",
    "registered by decorator": "from .registry import TABLE, register\nfrom .helper import used\n"
    "@register\ndef other(x):\n    return used(x)\ndef main(x):\n    return TABLE['other'](x)",
    "entry in another's table": "from .registry import TABLE\nfrom .writer import free\n"
    "def main(x):\n    return TABLE['k'](free(x))",
    "attribute of another's module": "from . import registry\nfrom .patcher import free\n"
    "def main(x):\n    return registry.TABLE(free(x))",
    "subclasses": "from .plugins import Plugin\ndef main(x):\n"
    "    return [p().run(x) for p in Plugin.__subclasses__()]",
    "init subclass": "from .plugins import Known\ndef main(x):\n    return Known.known",
    "dynamic module attribute": "from .dynamic import anything\ndef main(x):\n"
    "    return anything(x)",
    "exec": "def main(x):\n    exec('from nodes.toy.helper import used; used(1)')",
    "eval": "def main(x):\n    return eval('__import__(\"nodes.toy.helper\").used(1)')",
    "import_module": "from importlib import import_module\ndef main(x):\n"
    "    return import_module('nodes.toy.helper').used(x)",
    "importlib.import_module": "import importlib\ndef main(x):\n"
    "    return importlib.import_module('nodes.toy.helper').used(x)",
    "renamed import_module": "from importlib import import_module as load\ndef main(x):\n"
    "    return load('nodes.toy.helper').used(x)",
    "renamed importlib": "import importlib as il\ndef main(x):\n"
    "    return il.import_module('nodes.toy.helper').used(x)",
    "sys.modules": "import sys\ndef main(x):\n    return sys.modules['nodes.toy.helper'].used(x)",
    "from sys import modules": "from sys import modules as m\ndef main(x):\n"
    "    return m['nodes.toy.helper'].used(x)",
    "pkgutil": "import pkgutil\ndef main(x):\n"
    "    return pkgutil.resolve_name('nodes.toy.helper').used(x)",
    "importlib as value": "import importlib\ndef main(x):\n"
    "    return getattr(importlib, 'import_' + 'module')('nodes.toy.helper').used(x)",
    "globals": "from .helper import used\ndef main(x):\n    return globals()['used'](x)",
}
OTHERS = {
    "__init__": "from nodes.toy.helper import used as shown\n",
    "between": """
        from nodes.toy import helper
        from nodes.toy.helper import used

        class Base:
            def run(self, x):
                return used(x)
        """,
    "starry": "from .helper import *\n",
    "other": "def used(x):\n    return 0\n",
    "effect": "from .helper import used\nused(1)\n",
    "chain": "import nodes.toy.effect\n\ndef free(x):\n    return x\n",
    "registry": "TABLE = {}\n\ndef register(f):\n    TABLE[f.__name__] = f\n    return f\n",
    "writer": "from .registry import TABLE\nfrom .helper import used\nTABLE['k'] = used\n\n"
    "def free(x):\n    return x\n",
    "patcher": "from . import registry\nfrom .helper import used\nregistry.TABLE = used\n\n"
    "def free(x):\n    return x\n",
    "plugins": "from .helper import used\n\nclass Plugin:\n    pass\n\nclass One(Plugin):\n"
    "    def run(self, x):\n        return used(x)\n\n"
    "class Known:\n    known = []\n    def __init_subclass__(cls):\n"
    "        Known.known.append(cls)\n\n"
    "class Two(Known):\n    def run(self, x):\n        return used(x)\n",
    "dynamic": "from . import helper\n\ndef __getattr__(name):\n    return helper.used\n",
}


def with_way(sources: Sources, way: str) -> None:
    sources.write({"helper": HELPER, **OTHERS, "main": WAYS[way]})


@pytest.mark.parametrize("way", WAYS)
def test_an_edited_helper_counts_however_it_is_reached(sources: Sources, way: str) -> None:
    with_way(sources, way)
    assert sources.counts("helper", "x * FACTOR", "FACTOR * x")


@pytest.mark.parametrize("way", WAYS)
def test_a_constant_of_the_helper_counts_too(sources: Sources, way: str) -> None:
    with_way(sources, way)
    assert sources.counts("helper", "FACTOR = 2", "FACTOR = 3")


# Ways that name just one definition, so that another one beside it must not count.
VAGUE = {"exec", "eval", "import_module", "importlib.import_module", "renamed import_module"}
VAGUE |= {"renamed importlib", "sys.modules", "from sys import modules", "pkgutil", "globals"}
VAGUE |= {"importlib as value", "module as constant", "module as value", "module in a list"}
VAGUE |= {"module dictionary", "module variables", "star", "relative star", "through a star"}
VAGUE |= {"subclasses", "init subclass", "dynamic module attribute", "module of module"}


@pytest.mark.parametrize("way", [way for way in WAYS if way not in VAGUE])
def test_an_unused_neighbour_does_not_count(sources: Sources, way: str) -> None:
    with_way(sources, way)
    assert not sources.counts("helper", "x + UNUSED", "x - UNUSED")
    assert not sources.counts("helper", "UNUSED = 7", "UNUSED = 8")
    assert not sources.counts("helper", "size = 3", "size = 4")


@pytest.mark.parametrize("way", WAYS)
def test_every_way_that_the_tests_try_is_python(way: str) -> None:
    assert ast.parse(textwrap.dedent(WAYS[way])).body


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("return x * FACTOR", "# why\n    return (x *\n        FACTOR)  # so"),
        ("def used(x):\n", "def used(x):\n    '''Multiply.'''\n"),
        ("class Thing:\n", "class Thing:\n    '''A thing.'''\n"),
        ("    size = 3\n", "    size = 3\n    '''Size in mm.'''\n"),
        ("FACTOR = 2\n", "FACTOR = 2\n'''A factor.'''\n"),
        ("FACTOR = 2\n", "'''About the module.'''\nFACTOR = 2\n"),
    ],
)
def test_comments_docstrings_and_layout_do_not_count(sources: Sources, old: str, new: str) -> None:
    main = "from .helper import Thing, used\ndef main(x):\n    return used(Thing().size)\n"
    sources.write({"helper": HELPER, "main": main})
    assert not sources.counts("helper", old, new)


@pytest.mark.parametrize(
    "main",
    [
        "from .helper import used\ndef main(x):\n    return used.__doc__",
        "import inspect\nfrom .helper import used\ndef main(x):\n    return inspect.getdoc(used)",
        "from inspect import getdoc\nfrom .helper import used\ndef main(x):\n"
        "    return getdoc(used)",
        "from .reader import read\nfrom .helper import used\ndef main(x):\n    return read(used)",
        "import inspect\nfrom .helper import used\ndef main(x):\n"
        "    return inspect.getsource(used)",
    ],
)
def test_docstrings_count_where_something_reads_them(sources: Sources, main: str) -> None:
    helper = "def used(x):\n    '''Multiply.'''\n    return x\n"
    reader = "def read(f):\n    return f.__doc__\n"
    sources.write({"helper": helper, "reader": reader, "main": main})
    assert sources.counts("helper", "Multiply.", "Add.")


def test_the_modules_own_docstring_counts_where_it_is_read(sources: Sources) -> None:
    sources.write({"main": "'''Help.'''\n\ndef main(x):\n    return __doc__\n"})
    assert sources.counts("main", "Help.", "Other.")


def test_text_that_is_no_docstring_counts(sources: Sources) -> None:
    sources.write({"main": "TEXT = 'a'\ndef main(x):\n    return TEXT + 'b'\n"})
    assert sources.counts("main", "'a'", "'c'")
    assert sources.counts("main", "'b'", "'d'")


def test_data_files_beside_a_reached_module_count_and_others_do_not(sources: Sources) -> None:
    sources.write({"main": "from .sub.part import f\ndef main(x):\n    return f(x)\n"})
    sources.write({"sub/__init__": "", "sub/part": "def f(x):\n    return x\n"})
    for name in ("page.html", "assets/view.js", "sub/style.css", "../other/data.json"):
        sources.write({name: "one"})
    sources.write({"../other/__init__": ""})
    for name in ("page.html", "assets/view.js", "sub/style.css"):
        assert sources.counts(name, "one", "two"), name
    assert not sources.counts("../other/data.json", "one", "two")
    before = sources.reach()
    sources.write({"new.txt": "x"})
    assert sources.reach() != before
    after = sources.reach()
    sources.write({".new.txt.swp": "x", "new.txt~": "x", "__pycache__/main.pyc": "x"})
    assert sources.reach() == after


def test_a_folder_without_init_is_a_package_too(sources: Sources) -> None:
    sources.write({"main": "from nodes.toy.bare.part import f\ndef main(x):\n    return f(x)\n"})
    sources.write({"bare/part": "def f(x):\n    return 1\n", "__init__": "N = [1]\nN.append(2)\n"})
    assert sources.counts("bare/part", "return 1", "return 2")
    assert sources.counts("__init__", "append(2)", "append(3)")


def test_statements_of_packages_on_the_way_count(sources: Sources) -> None:
    sources.write({"main": "def main(x):\n    return x\n"})
    sources.write({"__init__": "import numpy\nnumpy.seterr(all='raise')\n"})
    assert sources.counts("__init__", "raise", "warn")


def test_recursion_and_import_cycles_end(sources: Sources) -> None:
    sources.write(
        {
            "main": "from .a import f\ndef main(x):\n    return f(x) or main(x)\n",
            "a": "from . import b\nfrom .main import main\ndef f(x):\n"
            "    return b.g(x) or main(x)\n",
            "b": "from .a import *\nfrom . import a\ndef g(x):\n    return a.f(x) or f(a)\n",
        }
    )
    assert sources.counts("b", "a.f(x)", "a.f(x + 1)")


def test_arguments_that_shadow_modules_do_no_harm(sources: Sources) -> None:
    text = """
        from nodes.toy import helper

        def main(helper, used, nodes, x=1):
            for used in helper.used.inner:
                nodes.toy.nothing(used)
            return [nodes for nodes in used] + [lambda main: main.x.y]
        """
    sources.write({"helper": HELPER, "main": text})
    assert f"{TARGET.replace(':', '.')}" in sources.reach().definitions


def test_a_name_that_is_nowhere_does_no_harm(sources: Sources) -> None:
    sources.write({"main": "from nodes.toy.gone import f\ndef main(x):\n    return f(x) + g.h\n"})
    assert list(sources.reach().definitions) == ["nodes.toy.main.main"]


def test_packages_are_those_imported_and_used_and_not_the_standard_library(
    sources: Sources,
) -> None:
    sources.write(
        {
            "main": """
                import json
                import numpy as np
                import os.path
                from scipy import ndimage
                from .helper import used
                def main(x):
                    import pandas
                    import trimesh.exchange.ply
                    import pydicom.encoders
                    return np.sum(x), json, used(x), os.path, trimesh.exchange.ply, pandas.DataFrame
                def other(x):
                    import prefect
                    return ndimage.label(x)
                """,
            "helper": "import skimage.measure\ndef used(x):\n    return skimage.measure.f(x)\n",
        }
    )
    assert sources.reach().packages == {"numpy", "pandas", "trimesh", "pydicom", "skimage"}


def test_a_new_conditional_branch_counts(sources: Sources) -> None:
    sources.write({"main": "try:\n    import numpy as np\nexcept ImportError:\n    np = None\n"
                           "def main(x):\n    return np\n"})  # fmt: skip
    assert sources.counts("main", "np = None", "np = 0")


def test_the_signature_is_that_of_the_source(sources: Sources) -> None:
    text = '''
        from nodes.toy.parameters import P
        def main(a: int, b, *more, c=1, parameters: P) -> int:
            """Do it.

            More.
            """
        THING = 3
        '''
    sources.write({"main": text})
    signature = SourceTree(sources.root).signature(TARGET)
    assert (signature.summary, signature.arguments) == ("Do it.", ("a", "b", "c"))
    assert (signature.takes_more, signature.parameters_type) == (True, "P")
    for wrong in ("nodes.toy.main:gone", "nodes.toy.gone:main", "nodes.toy.main:THING"):
        with pytest.raises(LookupError):
            SourceTree(sources.root).signature(wrong)
