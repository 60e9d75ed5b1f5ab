from __future__ import annotations

import posixpath
import re
from importlib.resources import files

import pytest
from fastapi.testclient import TestClient
from pydantic import SecretStr

from motionsplice.runtime.bank import Bank
from motionsplice.service.app import create_app
from motionsplice.service.settings import Settings
from motionsplice.service.viewer.routes import page_files


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


def test_it_is_small(client: TestClient) -> None:
    """What the page loads at first, without what it imports when it is needed."""
    found, waiting = {"index.html", "style.css", "timeline/timeline.css"}, ["main.js"]
    while waiting:
        path = waiting.pop()
        found.add(path)
        text = page_files()[path].plain.decode()
        for name in re.findall(r"from ?['\"](\./?[\w./]+\.js)['\"]", text):
            target = posixpath.normpath(posixpath.join(posixpath.dirname(path), name))
            waiting += [target] if target not in found else []
    assert {"viewer.js", "vendor/three.js", "vendor/shared.js", "scene/body.js"} <= found
    assert "vendor/loader.js" not in found
    assert sum(len(page_files()[path].compressed) for path in found) < 250_000


def test_modules_and_styles_are_sent_without_their_comments(client: TestClient) -> None:
    text = client.get("/view/player.js").text
    assert "/**" not in text
    assert "export class Player {" in text
    style = client.get("/view/style.css").text
    assert "/*" not in style
    assert style.startswith(":root {")


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
