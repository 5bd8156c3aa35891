"""The page's files: kept by browsers, and never used stale."""

from __future__ import annotations

import asyncio
import re
from pathlib import Path

import pytest
from starlette.exceptions import HTTPException
from starlette.responses import Response

from keypose import static
from keypose.app.server.page_files import PageFiles

STATIC = Path(static.__file__).parent
INDEX = '<script type="module" src="/files/page.js"></script>'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "index.html").write_text(INDEX)
    (tmp_path / "page.js").write_text("one")
    return tmp_path


def asked(files: PageFiles, path: str, **headers: str) -> Response:
    given = [(name.replace("_", "-").encode(), value.encode()) for name, value in headers.items()]
    scope = {"type": "http", "method": "GET", "path": path, "headers": given}
    return asyncio.run(files.get_response(path, scope))


def address_in(page: str) -> str:
    found = re.search(r'src="/files/([0-9a-f]{16}/page\.js)"', page)
    assert found is not None, page
    return found[1]


def test_a_browser_keeps_what_the_page_leads_to_and_does_not_ask_again(folder: Path) -> None:
    files = PageFiles(folder, "/files")
    answer = asked(files, address_in(files.page()))
    assert answer.status_code == 200
    assert answer.headers["cache-control"] == "private, max-age=31536000, immutable"


def test_the_page_leads_to_other_addresses_once_any_file_has_changed(folder: Path) -> None:
    files = PageFiles(folder, "/files")
    before = address_in(files.page())
    assert address_in(files.page()) == before
    (folder / "deep").mkdir()
    (folder / "deep" / "one_more.css").write_text("")
    after = address_in(files.page())
    assert after != before
    assert asked(files, after).status_code == 200
    with pytest.raises(HTTPException, match="404"):
        asked(files, before)


def test_what_was_read_once_is_answered_as_it_was_without_the_disk(folder: Path) -> None:
    files = PageFiles(folder, "/files")
    address = address_in(files.page())
    first = asked(files, address)
    (folder / "page.js").unlink()
    again = asked(files, address)
    assert (again.status_code, again.body, again.raw_headers) == (200, b"one", first.raw_headers)
    with pytest.raises(HTTPException, match="404"):
        asked(files, "page.js")


def test_another_server_of_the_same_files_has_the_same_addresses(folder: Path) -> None:
    first = address_in(PageFiles(folder, "/files").page())
    assert asked(PageFiles(folder, "/files"), first).status_code == 200


def test_a_browser_asks_again_for_what_it_asked_for_without_a_version(folder: Path) -> None:
    files = PageFiles(folder, "/files")
    first = asked(files, "page.js")
    assert first.headers["cache-control"] == "no-cache"
    known = first.headers["etag"]
    unchanged = asked(files, "page.js", if_none_match=known)
    assert (unchanged.status_code, unchanged.headers["cache-control"]) == (304, "no-cache")
    (folder / "page.js").write_text("another")
    assert asked(files, "page.js", if_none_match=known).status_code == 200


def test_style_sheets_come_as_one_with_the_rules_of_all_in_their_order(folder: Path) -> None:
    for name, rules in {
        "one.css": '@import url("parts/two.css");\na {}\n',
        "parts/two.css": "b {}\n",
        "three.css": "c {}\n",
    }.items():
        (folder / "style" / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / "style" / name).write_text(rules)
    links = [f'<link rel="stylesheet" href="/files/style/{n}.css" />\n' for n in ("one", "three")]
    (folder / "index.html").write_text(f"<head>{''.join(links)}{INDEX}</head>")
    files = PageFiles(folder, "/files")
    page = files.page()
    (address,) = re.findall(r'<link rel="stylesheet" href="/files/([^"]+)" />', page)
    assert address_in(page).split("/")[0] == address.split("/")[0]
    answer = asked(files, address)
    assert bytes(answer.body).decode().split("\n") == ["b {}", "", "a {}", "c {}", ""]
    assert answer.headers["content-type"].startswith("text/css")
    assert "immutable" in answer.headers["cache-control"]


def test_the_page_has_one_style_sheet_and_leaves_none_out() -> None:
    static = Path(__file__).parents[3] / "static"
    files = PageFiles(static, "/static")
    (address,) = re.findall(r'<link rel="stylesheet" href="/static/([^"]+)" />', files.page())
    whole = bytes(asked(files, address).body).decode()
    assert "@import" not in whole
    texts = (sheet.read_text("utf-8") for sheet in (static / "style").rglob("*.css"))
    rules = [re.sub(r"@import .*\n", "", text).strip() for text in texts]
    assert [each for each in rules if each.splitlines()[-1] not in whole] == []


def test_the_page_names_every_module_that_its_own_leads_to_and_no_other() -> None:
    static = Path(__file__).parents[3] / "static"
    page = PageFiles(static, "/static").page()
    named = re.findall(r'<link rel="modulepreload" href="/static/[0-9a-f]{16}/([^"]+)" />', page)
    assert len(named) == len(set(named)) > 100
    importing = re.compile(r"""(?:from|^import)\s+'(\.[^']+)';""", re.MULTILINE)
    led_to = {
        (static / name).parent.joinpath(to).resolve().relative_to(static).as_posix()
        for name in ("page.js", *named)
        for to in importing.findall((static / name).read_text("utf-8"))
    }
    assert set(named) == led_to


def test_no_file_of_the_page_names_another_by_an_address_without_a_version() -> None:
    static = Path(__file__).parents[3] / "static"
    whole = re.compile(r"""(?:from|import|url\()\s*['"(]?/static/""")
    files = [*static.rglob("*.js"), *static.rglob("*.css")]
    assert len(files) > 100
    assert [str(file) for file in files if whole.search(file.read_text(encoding="utf-8"))] == []


@pytest.mark.parametrize("versioned", [False, True])
def test_nothing_is_served_but_what_a_page_is_made_of(versioned: bool) -> None:
    files = PageFiles(STATIC, "/files")
    version = re.search(r"/files/([0-9a-f]{16})/", files.page())
    assert version is not None
    before = f"{version[1]}/" if versioned else ""
    for path in sorted(STATIC.rglob("*")):
        name = path.relative_to(STATIC).as_posix()
        if path.suffix in (".js", ".css", ".svg", ".woff2"):
            assert asked(files, before + name).status_code == 200, name
        else:
            with pytest.raises(HTTPException, match="404"):
                asked(files, before + name)
