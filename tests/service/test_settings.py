"""Settings of the service: what is refused, and what is brought into the form that requests are compared with."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from pydantic import SecretStr
from typer.testing import CliRunner

from motionsplice.cli import app
from motionsplice.motion.errors import SettingsError
from motionsplice.service.settings import Settings, unknown_variables


def test_settings_of_the_environment_are_read_and_checked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MOTIONSPLICE_PORT", "8123")
    monkeypatch.setenv("MOTIONSPLICE_ORIGINS", "http://one.example, http://two.example")
    assert Settings().port == 8123
    assert Settings().origins == ("http://one.example", "http://two.example")
    monkeypatch.setenv("MOTIONSPLICE_PORT", "soon")
    with pytest.raises(SettingsError, match=r"MOTIONSPLICE_PORT is 'soon'.* Set another value\b.* its flag"):
        Settings()


def test_every_setting_is_in_the_documentation() -> None:
    page = (Path(__file__).parents[2] / "docs" / "operation.md").read_text()
    rows = [line.split("|")[1] for line in page[page.index("| setting |") :].split("\n\n")[0].splitlines()[2:]]
    assert sorted(re.findall(r"`(\w+)`", "".join(rows))) == sorted(Settings.model_fields)


@pytest.mark.parametrize("token", ["open-sesame\n", " open-sesame"])
def test_a_token_that_no_client_can_send_is_refused(token: str) -> None:
    with pytest.raises(SettingsError, match="MOTIONSPLICE_TOKEN begins or ends with white space") as caught:
        Settings(token=SecretStr(token))
    assert token.strip() not in str(caught.value)


@pytest.mark.parametrize("name", sorted(set(Settings.model_fields) - {"origins", "hosts"}))
def test_an_empty_value_is_refused(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(f"MOTIONSPLICE_{name.upper()}", "")
    with pytest.raises(SettingsError, match=f"MOTIONSPLICE_{name.upper()} is empty. Give it a value, or unset it"):
        Settings()


@pytest.mark.parametrize("flag", ["host", "token", "clips", "copies", "report"])
def test_an_empty_flag_is_refused(flag: str) -> None:
    with pytest.raises(SettingsError, match=f"MOTIONSPLICE_{flag.upper()} is empty"):
        CliRunner().invoke(app, ["serve", "bank", f"--{flag}", ""], catch_exceptions=False)


def test_an_empty_list_has_no_entries(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("ORIGINS", "HOSTS"):
        monkeypatch.setenv(f"MOTIONSPLICE_{name}", "")
    assert (Settings().origins, Settings().hosts) == ((), ())


@pytest.mark.parametrize(
    ("listed", "compared"),
    [
        ("https://Game.example/", "https://game.example"),
        ("https://game.example:443", "https://game.example"),
        ("http://game.example:443", "http://game.example:443"),
        ("http://[::1]:8080", "http://[::1]:8080"),
        ("capacitor://localhost", "capacitor://localhost"),
        ("*", "*"),
        ("null", "null"),
    ],
)
def test_origins_are_as_browsers_send_them(listed: str, compared: str) -> None:
    assert Settings(origins=(listed,)).origins == (compared,)


@pytest.mark.parametrize(
    "wrong", ["game.example", "https://game.example/play", "https://*.example", "https://a@b", "//a"]
)
def test_an_origin_that_no_page_has_is_refused(wrong: str) -> None:
    with pytest.raises(
        SettingsError, match=r"MOTIONSPLICE_ORIGINS has .*, which is not a web origin. Write it as https"
    ):
        Settings(origins=(wrong,))


@pytest.mark.parametrize(
    ("listed", "compared"),
    [
        ("Game.example:18434", "game.example"),
        ("game.example.", "game.example"),
        ("my_service", "my_service"),
        ("192.0.2.1:80", "192.0.2.1"),
        ("[::1]:80", "::1"),
        ("2001:DB8::1", "2001:db8::1"),
        ("*", "*"),
    ],
)
def test_hosts_are_names_without_ports(listed: str, compared: str) -> None:
    assert Settings(hosts=(listed,)).hosts == (compared,)


@pytest.mark.parametrize("wrong", ["https://game.example", "game.example/", "*.example", "a b"])
def test_a_host_that_no_request_can_name_is_refused(wrong: str) -> None:
    with pytest.raises(
        SettingsError, match=r"MOTIONSPLICE_HOSTS has .*, which is not the name of a host. Write it as game"
    ):
        Settings(hosts=(wrong,))


def test_variables_that_are_no_settings_are_found() -> None:
    assert unknown_variables({"MOTIONSPLICE_PORT": "1", "motionsplice_host": "a", "PATH": "b"}) == []
    assert unknown_variables({"MOTIONSPLICE_ORIGIN": "*", "MOTIONSPLICE_MAX": "1"}) == [
        "MOTIONSPLICE_MAX",
        "MOTIONSPLICE_ORIGIN",
    ]


def test_links_to_services_are_no_unknown_settings() -> None:
    links = {
        f"{service}_{end}": "x"
        for service in ("MOTIONSPLICE", "MOTIONSPLICE_DASK")
        for end in ("SERVICE_HOST", "SERVICE_PORT", "SERVICE_PORT_HTTP", "PORT_80_TCP", "PORT_80_TCP_ADDR", "PORT")
    }
    assert unknown_variables(links) == []
    assert unknown_variables({"MOTIONSPLICE_DASK_PORT": "x"}) == ["MOTIONSPLICE_DASK_PORT"]
