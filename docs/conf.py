"""How Sphinx builds this folder into the documentation: `make docs`.

Two pages are written anew by each build from what they describe: `commands.md` from the command line, `rig_file.md`
from the registry of settings. Nothing on a built page is loaded from a network: formulas are MathML, fonts the
reader's own.
"""

import re
import subprocess
import sys
from pathlib import Path

import latex2mathml.converter
from docutils.nodes import SkipNode, math, math_block
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

from experiments.request.rig_template import commented

project = "camring"
author = "the authors of camring"
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_copybutton"]
exclude_patterns = ["images/README.md"]

html_theme = "furo"
html_title = "camring"
html_static_path = ["_static"]
html_css_files = ["page.css"]
html_math_renderer = "mathml"
html_show_sphinx = False
html_show_copyright = False
html_copy_source = False
html_show_sourcelink = False

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3  # links to headings work here as they do where the sources are read
nb_execution_mode = "off"  # the tutorial is stored as it ran; a test runs it again
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True

smartquotes = False  # it makes one dash of the two before an option
default_role = "py:obj"
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = True
autodoc_typehints = "none"  # the docstrings tell types together with shapes
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True}
toc_object_entries_show_parents = "hide"


def formula(translator: HTML5Translator, node: math | math_block) -> None:
    """One formula as MathML, which browsers set by themselves."""
    display = "block" if isinstance(node, math_block) else "inline"
    translator.body.append(latex2mathml.converter.convert(node.astext(), display=display))
    raise SkipNode


def write_generated_pages(app: Sphinx) -> None:
    """`commands.md` and `rig_file.md`, from what they describe."""
    command = [sys.executable, "-m", "typer", "experiments.cli.app", "utils", "docs", "--name", "camring"]
    written = subprocess.run(command, check=True, capture_output=True, text=True, encoding="utf-8").stdout
    head = "# Every command and option\n\nAs `camring --help` and `camring optimise --help` say it, too.\n\n"
    written = re.sub(r"^Example: (camring .+)$", r"Example: `\1`", written, flags=re.M)
    written = re.sub(r"\[default: \((.+)\)\]$", r"[default: \1]", written, flags=re.M)
    commands = head + written.split("\n", 1)[1].strip() + "\n"
    settings = (
        "# Every key of a rig file\n\nWhat `camring rig init` writes. All keys have defaults and may be left out.\n\n"
        f"```toml\n{commented()}```\n"
    )
    for name, text in (("commands.md", commands), ("rig_file.md", settings)):
        (Path(app.srcdir) / name).write_text(text, encoding="utf-8")


def offer_files_of_the_repository(_app: Sphinx, _page: str, source: list[str]) -> None:
    """Links to Markdown files outside this folder, such as tables of results, hand over the file itself."""
    source[0] = re.sub(r"\]\((\.\./[^)#]*/results/[^)#]*\.md)\)", r"](<path:\1>)", source[0])


def setup(app: Sphinx) -> None:
    """Called by Sphinx."""
    app.add_html_math_renderer("mathml", inline_renderers=(formula, None), block_renderers=(formula, None))
    app.connect("source-read", offer_files_of_the_repository)
    app.connect("builder-inited", write_generated_pages)
