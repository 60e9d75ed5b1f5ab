"""Settings of the service, from the environment (`MOTIONSPLICE_HOST` ...) or given."""

from __future__ import annotations

from typing import Any, Self

from pydantic import Field, ModelWrapValidatorHandler, ValidationError, model_validator
from pydantic_settings import BaseSettings, SettingsConfigDict

from motion.errors import SettingsError

PREFIX = "MOTIONSPLICE_"


class Settings(BaseSettings):
    """Where the service listens, and how much one request may ask for. Raises SettingsError."""

    model_config = SettingsConfigDict(env_prefix=PREFIX)

    host: str = "127.0.0.1"
    port: int = Field(default=8000, ge=0, le=65535)
    max_frames: int = Field(default=1_000_000, ge=1, description="Most frames in one streamed splice")

    @model_validator(mode="wrap")
    @classmethod
    def _or_settings_error(cls, values: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        try:
            return handler(values)
        except ValidationError as error:
            wrong = [f"{_variable(one['loc'])} is {one['input']!r}: {one['msg']}" for one in error.errors()]
            raise SettingsError("; ".join(wrong), mend="Set it to another value, or unset it") from None


def _variable(place: tuple[int | str, ...]) -> str:
    return PREFIX + ".".join(map(str, place)).upper()
