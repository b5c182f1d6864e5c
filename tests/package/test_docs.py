"""What the documents promise without being built: all examples, all public names, only snippets that run."""

import json
import re
import sys

import pytest

import kanefe
import kanefe_fem
from kanefe._public import homes
from repository import ROOT

DOCS = ROOT / "docs"
PAGES = sorted(p for p in DOCS.rglob("*.md") if not {"_ext", "_generated", "gallery", "notebooks"} & set(p.parts))


def text_of(path):
    return path.read_text(encoding="utf-8")


def test_every_example_has_a_picture():
    drawings = text_of(DOCS / "_ext" / "drawings.py")
    pictured = re.findall(r'^    "(\d\d_\w+)": ', drawings, flags=re.MULTILINE)
    assert sorted(pictured) == sorted(p.stem for p in (ROOT / "examples").glob("[0-9]*.py"))


@pytest.mark.parametrize("package", [kanefe, kanefe_fem], ids=lambda p: p.__name__)
def test_every_public_name_is_in_the_reference(package):
    # a page a room, with all its names: what is needed is that the room has a page
    rooms = re.findall(r'^    "(\w+)": ".+",$', text_of(DOCS / "_ext" / "reference.py"), flags=re.MULTILINE)
    assert {home.split(".")[1] for home in homes(package.__file__).values()} <= set(rooms)


def test_every_error_and_warning_is_explained():
    code = "".join(text_of(p) for folder in ("kanefe", "fem/kanefe_fem") for p in (ROOT / folder).rglob("*.py"))
    classes = set(re.findall(r"^class (\w+Warning)\(", code, re.MULTILINE))
    classes |= set(re.findall(r"^class (\w+)\(", text_of(ROOT / "kanefe" / "errors.py"), re.MULTILINE))
    explained = text_of(DOCS / "messages.md")
    assert {name for name in classes if name not in explained} == set()


def test_every_page_is_in_a_list_of_contents():
    listed = set()
    for page in PAGES:
        for block in re.findall(r"```\{toctree\}\n(.*?)```", text_of(page), flags=re.DOTALL):
            names = (line.strip() for line in block.splitlines() if line.strip() and not line.startswith(":"))
            listed |= {(page.parent / re.sub(r".*<(.*)>", r"\1", name)).resolve() for name in names}
    missing = {p for p in PAGES if p.with_suffix("").resolve() not in listed} - {DOCS / "index.md"}
    assert missing == set()


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.relative_to(DOCS).as_posix())
def test_snippets_are_found_and_compile(page):
    sys.path.insert(0, str(DOCS / "_ext"))
    try:
        from page_snippets import snippets_of
    finally:
        sys.path.pop(0)
    text = text_of(page)
    for snippet in snippets_of(text):
        compile(snippet["code"], page.name, "exec")
    opened = len(re.findall(r"^```python", text, flags=re.MULTILINE))
    not_run = len(re.findall(r"^<!-- not run: \S.*-->\n```python", text, flags=re.MULTILINE))
    hidden = len(re.findall(r"^<!-- run$", text, flags=re.MULTILINE))
    assert len(snippets_of(text)) == opened - not_run + hidden


@pytest.mark.parametrize("path", sorted((DOCS / "data").glob("*.json")), ids=lambda p: p.stem)
def test_figures_tell_machine_and_date(path):
    told = json.loads(text_of(path))
    assert re.fullmatch(r"\d{4}-\d\d-\d\d", told["date"])
    assert told["machine"]
    for table in told.get("tables", {}).values():
        assert {len(row) for row in table["rows"]} == {len(table["columns"])}


@pytest.mark.parametrize("path", sorted((DOCS / "notebooks").glob("*.py")), ids=lambda p: p.stem)
def test_notebooks_have_a_title_and_compile(path):
    text = text_of(path)
    assert re.match(r"# %% \[markdown\]\n# # \S.*\n#\n# \S", text)
    compile(text, path.name, "exec")
