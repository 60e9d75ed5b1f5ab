"""The OpenAPI document, `/openapi.json`."""
