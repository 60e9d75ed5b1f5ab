from fastapi.openapi.utils import get_openapi


def document(app, shared):
    return get_openapi(title=app.title, version=app.version, description=app.description, routes=app.routes)
