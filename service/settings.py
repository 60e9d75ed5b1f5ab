"""Settings of the service, from the environment (`MOTIONSPLICE_HOST` ...) or given."""

from __future__ import annotations

from pydantic import Field
from pydantic_settings import BaseSettings, SettingsConfigDict


class Settings(BaseSettings):
    """Where the service listens, and how much one request may ask for."""

    model_config = SettingsConfigDict(env_prefix="MOTIONSPLICE_")

    host: str = "127.0.0.1"
    port: int = Field(default=8000, ge=0, le=65535)
    max_frames: int = Field(default=1_000_000, ge=1, description="Most frames in one streamed splice")
