"""The objects of a process that its protocols share."""

from __future__ import annotations

from functools import cached_property

import uvicorn

from motionsplice.service.edge.hosts import Hosts
from motionsplice.service.edge.known_heads import AnswerHead, KnownHeaders
from motionsplice.service.edge.ledger import Ledger
from motionsplice.service.front import Front
from motionsplice.service.settings import Settings


class EdgeContext(uvicorn.Config):
    """uvicorn's configuration, which each protocol receives: settings, the application, and the ledger."""

    settings: Settings

    @cached_property
    def front(self) -> Front:
        """The application, once loaded."""
        assert isinstance(self.loaded_app, Front)
        return self.loaded_app

    @cached_property
    def known_headers(self) -> KnownHeaders:
        """The headers of earlier requests."""
        return KnownHeaders()

    @cached_property
    def answer_head(self) -> AnswerHead:
        """The first lines of answers."""
        return AnswerHead()

    @cached_property
    def ledger(self) -> Ledger:
        """The open connections of this process."""
        settings = self.settings
        gauge = self.front.shared.metrics.connections("http")
        return Ledger(settings.max_connections, settings.max_connections_per_address, gauge)

    @cached_property
    def hosts(self) -> Hosts:
        """The names by which the service may be called."""
        return Hosts(self.settings)
