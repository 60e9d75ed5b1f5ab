"""Settings of the service, from arguments or the environment (`MOTIONSPLICE_HOST` ...)."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import (
    Field,
    ModelWrapValidatorHandler,
    SecretStr,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)
from pydantic_core import ErrorDetails
from pydantic_settings import BaseSettings, NoDecode, SettingsConfigDict

from motionsplice.motion.errors import SettingsError
from motionsplice.sending.receiver import PORTS, Kind, host_and_port
from motionsplice.service.origins import listed_host, listed_origin

PREFIX = "MOTIONSPLICE_"
LISTS = {
    "origins": (listed_origin, "a web origin", "Write it as https://game.example or http://localhost:8080"),
    "hosts": (listed_host, "the name of a host", "Write it as game.example"),
}
SECOND = Annotated[float, Field(gt=0.0, le=3600.0, allow_inf_nan=False)]


class Settings(BaseSettings):
    """The address, access control and limits of the service. Raises SettingsError if a value is invalid."""

    model_config = SettingsConfigDict(env_prefix=PREFIX, extra="forbid")

    host: str = Field(default="127.0.0.1", description="Address to listen on")
    port: int = Field(default=8000, ge=0, le=65535, description="Port; 0 chooses a free one")
    workers: int = Field(default=1, ge=1, le=256, description="Processes that share the port and the mapped bank")
    watch: bool = Field(default=False, description="Serve a new bank when one is written in place of the old")
    copies: Path | None = Field(
        default=None,
        description="Folder for copies of banks at URLs, or that others may write over; default: user's cache",
    )
    clips: Path | None = Field(default=None, description="Folder for uploaded clips; without it, uploads are refused")
    report: Path | None = Field(default=None, description="scores.json of `bench.quality`, which /view/report shows")
    token: SecretStr | None = Field(
        default=None,
        min_length=8,
        description="Token that clients must send, 8 characters or more; without it, all are answered",
    )
    origins: Annotated[tuple[str, ...], NoDecode] = Field(
        default=(), description="Web origins whose pages may send requests, comma-separated; * for all"
    )
    hosts: Annotated[tuple[str, ...], NoDecode] = Field(
        default=(), description="Names by which clients call the service, comma-separated; * for all"
    )

    vmc: str | None = Field(default=None, description="HOST[:PORT] of a program that receives characters as VMC")
    livelink: str | None = Field(
        default=None, description="HOST[:PORT] of a program that receives characters as JSON Live Link"
    )

    max_header: int = Field(default=16 * 1024, ge=1024, description="Bytes of a request line and headers")
    max_body: int = Field(default=4 * 2**20, ge=1024, description="Bytes of a batch of poses")
    max_upload: int = Field(default=256 * 2**20, ge=1024, description="Bytes of an uploaded clip")
    max_clips: int = Field(default=10_000, ge=1, description="Files in the folder of uploaded clips")
    max_stored: int = Field(default=8 * 2**30, ge=1024, description="Bytes in the folder of uploaded clips")
    max_message: int = Field(default=64 * 1024, ge=1024, description="Bytes of a message of commands over a WebSocket")
    max_rig: int = Field(default=2**20, ge=1024, description="Bytes of the rig of a character in a take")
    max_batch: int = Field(default=10_000, ge=1, description="Characters in a batch of poses")
    max_characters: int = Field(default=10_000, ge=1, description="Characters of one WebSocket")
    max_frames: int = Field(
        default=20_000, ge=1, description="Frames of one splice; a stream may have 100 times as many"
    )
    max_rate: float = Field(
        default=120.0, ge=1.0, le=1000.0, description="Frames per second of a WebSocket or a paced stream"
    )
    max_ahead: int = Field(default=120, ge=1, le=1000, description="Frames in one message")
    max_commands: int = Field(default=1000, ge=1, description="Commands per second of one WebSocket; further ones wait")
    max_load: int = Field(
        default=600_000,
        ge=1,
        description="Characters evaluated per second for all WebSockets, or in batches of an address, in each process",
    )
    max_streams: int = Field(default=256, ge=1, description="Streams and WebSockets at once, in each process")
    max_connections: int = Field(default=4096, ge=1, description="Connections at once, in each process")
    max_connections_per_address: int = Field(
        default=512, ge=1, description="Connections at once of one address, in each process"
    )

    request_seconds: SECOND = Field(default=10.0, description="Seconds in which a request must arrive")
    idle_seconds: SECOND = Field(default=60.0, description="Seconds after which an unused connection is closed")
    stall_seconds: SECOND = Field(default=8.0, description="Seconds after which a client that reads nothing is cut off")
    stop_seconds: SECOND = Field(default=3.0, description="Seconds that streams have to end when the service stops")

    @model_validator(mode="before")
    @classmethod
    def _refuse_empty(cls, values: dict[str, Any]) -> dict[str, Any]:
        """Refuses what an unset variable of a shell or a compose file leaves: no host would be all addresses."""
        for name, value in values.items():
            if value == "" and name not in LISTS:
                raise SettingsError(f"{variable(name)} is empty", mend="Give it a value, or unset it")
        return values

    @field_validator("token")
    @classmethod
    def _refuse_untrimmed(cls, token: SecretStr | None) -> SecretStr | None:
        """Refuses a token that no header can carry: that of a file often ends with a newline."""
        if token is not None and (text := token.get_secret_value()) != text.strip():
            problem = f"{variable('token')} begins or ends with white space, which clients cannot send"
            raise SettingsError(problem, mend="Leave out the newline at its end, as `printf %s` does")
        return token

    @field_validator(*LISTS, mode="before")
    @classmethod
    def _split(cls, listed: Any) -> Any:
        return tuple(one.strip() for one in listed.split(",") if one.strip()) if isinstance(listed, str) else listed

    @field_validator(*LISTS)
    @classmethod
    def _as_compared(cls, listed: tuple[str, ...], about: ValidationInfo) -> tuple[str, ...]:
        """Brings entries into the form that requests are compared with, and refuses those that none could match."""
        name = about.field_name or ""
        compared, kind, mend = LISTS[name]
        if wrong := [one for one in listed if compared(one) is None]:
            raise SettingsError(f"{variable(name)} has {wrong[0]!r:.100}, which is not {kind}", mend=mend)
        return tuple(filter(None, map(compared, listed)))

    @model_validator(mode="after")
    def _check_receivers(self) -> Self:
        for kind, address in self.receivers.items():
            host_and_port(address, PORTS[kind], f"{variable(kind)} {address}")
        if self.receivers and self.workers > 1:
            problem = f"{variable('workers')} is {self.workers}, but only one process can send to a receiver"
            raise SettingsError(problem, mend="Set it to 1, or name no receiver")
        return self

    @property
    def receivers(self) -> dict[Kind, str]:
        """The addresses of receivers, by kind."""
        addresses: dict[Kind, str | None] = {"vmc": self.vmc, "livelink": self.livelink}
        return {kind: address for kind, address in addresses.items() if address is not None}

    @model_validator(mode="wrap")
    @classmethod
    def _or_settings_error(cls, values: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        try:
            return handler(values)
        except ValidationError as error:
            wrong = [f"{variable(*one['loc'])} {_problem(one)}" for one in error.errors()]
            raise SettingsError(
                "; ".join(wrong), mend="Set another value by the variable or its flag, or none"
            ) from None


def _problem(error: ErrorDetails) -> str:
    return "is too short" if "token" in error["loc"] else f"is {error['input']!r}: {error['msg']}"


def variable(*place: int | str) -> str:
    """Returns the environment variable of a setting."""
    return PREFIX + ".".join(map(str, place)).upper()


def unknown_variables(environment: Mapping[str, str]) -> list[str]:
    """Returns the variables that look like settings and are none; not those that Kubernetes makes for Services."""
    names = {name.upper() for name in environment if name.upper().startswith(PREFIX)}
    services = {name.removesuffix("_SERVICE_HOST") for name in names if name.endswith("_SERVICE_HOST")}
    links = tuple(f"{service}_{kind}" for service in services for kind in ("SERVICE_HOST", "SERVICE_PORT", "PORT"))
    return sorted(
        name for name in names - {variable(one) for one in Settings.model_fields} if not name.startswith(links)
    )
