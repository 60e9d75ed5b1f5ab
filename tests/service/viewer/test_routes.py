from __future__ import annotations

import re
from importlib.resources import files

import pytest
from fastapi.testclient import TestClient
from pydantic import SecretStr

from motionsplice.runtime.bank import Bank
from motionsplice.service.app import create_app
from motionsplice.service.settings import Settings
from motionsplice.service.viewer.routes import page_files, without_comments


def test_the_page_and_all_it_loads_are_served(client: TestClient) -> None:
    page = client.get("/view?locomotion=walk", follow_redirects=True)
    assert str(page.url).endswith("/view/?locomotion=walk")
    assert page.headers["content-type"] == "text/html; charset=utf-8"
    assert "'unsafe" not in page.headers["content-security-policy"]
    linked = re.findall(r'(?:src|href)="([^":]+\.(?:js|css))"', page.text)
    assert "main.js" in linked
    seen = set(linked)
    while linked:
        path = linked.pop()
        answer = client.get(f"/view/{path}")
        assert answer.status_code == 200, path
        assert answer.headers["content-type"].startswith("text/javascript" if path.endswith("js") else "text/css")
        if path.startswith("vendor/"):
            continue
        for found in re.findall(r"from '([^']+)'", answer.text):
            folder = path.split("/")[:-1]
            for part in found.split("/"):
                folder = folder[:-1] if part == ".." else folder if part == "." else [*folder, part]
            if (name := "/".join(folder)) not in seen:
                seen.add(name)
                linked.append(name)


def test_its_files_are_compressed_and_cached(client: TestClient) -> None:
    plain = client.get("/view/main.js", headers={"accept-encoding": "identity"})
    packed = client.get("/view/main.js", headers={"accept-encoding": "gzip"})
    assert "content-encoding" not in plain.headers
    assert packed.headers["content-encoding"] == "gzip"
    assert packed.content == plain.content
    again = client.get("/view/main.js", headers={"if-none-match": plain.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")


def test_comments_are_left_out_and_lines_keep_their_numbers() -> None:
    for path, file in page_files().items():
        source = (files("motionsplice.service.viewer") / "page" / path).read_bytes()
        assert file.plain.count(b"\n") == source.count(b"\n")
        assert file.plain == source or not path.startswith("vendor/")
        assert b"\n/**" not in file.plain or path.startswith("vendor/")
    source = b"/** Two\n * lines. */\nf('// text'); // why\n  // one line\n  g(`\n/* ${x}`);\n"
    assert without_comments(source) == b"\n\nf('// text'); // why\n\n  g(`\n/* ${x}`);\n"


def test_it_is_small() -> None:
    assert sum(len(file.compressed) for file in page_files().values()) < 250_000


@pytest.mark.parametrize(
    "path", ["nothing.js", "../routes.py", "vendor/three.d.ts", "vendor/../../routes.py", "/etc/passwd"]
)
def test_there_is_nothing_else(client: TestClient, path: str) -> None:
    assert client.get(f"/view/{path}").status_code == 404


def test_the_page_needs_no_token(bank: Bank) -> None:
    with TestClient(create_app(bank, Settings(token=SecretStr("secret-token")))) as guarded:
        assert guarded.get("/view/").status_code == 200
        assert guarded.get("/view/main.js").status_code == 200
        assert guarded.get("/v1/clips").status_code == 401


def test_all_licences_are_there() -> None:
    vendor = files("motionsplice.service.viewer") / "page" / "vendor"
    assert "MIT" in (vendor / "three.LICENSE").read_text()
