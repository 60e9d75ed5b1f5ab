# The wheel, its dependencies, the compiled kernels and a bank of the built-in motions.
FROM python:3.11-slim AS build
WORKDIR /source
COPY pyproject.toml README.md LICENSE ./
COPY motionsplice motionsplice
COPY motion motion
COPY runtime runtime
COPY precompute precompute
COPY service service
RUN python -m venv /opt/motionsplice && /opt/motionsplice/bin/pip install --no-cache-dir '.[cluster,fbx,s3]'
# Kernels are compiled for any x86-64 with AVX2, so that the cache fits wherever the image runs; --build-arg
# CPU=generic is for other processors.
ARG CPU=haswell
ENV NUMBA_CACHE_DIR=/opt/motionsplice/kernels NUMBA_CPU_NAME=$CPU NUMBA_CPU_FEATURES=""
RUN /opt/motionsplice/bin/motionsplice demo /demo && rm -r /demo/bank/cache && /opt/motionsplice/bin/python -c \
    "from motionsplice.runtime.bank import Bank; from motionsplice.service.serving import Edition; Edition.warm(Bank.open('/demo/bank'))"

FROM python:3.11-slim
ARG CPU=haswell
RUN useradd --system --uid 10001 --no-create-home --shell /usr/sbin/nologin motionsplice
COPY --from=build /opt/motionsplice /opt/motionsplice
COPY --from=build /demo/bank /bank
ENV PATH=/opt/motionsplice/bin:$PATH \
    NUMBA_CACHE_DIR=/opt/motionsplice/kernels NUMBA_CPU_NAME=$CPU NUMBA_CPU_FEATURES="" \
    MOTIONSPLICE_HOST=0.0.0.0 MOTIONSPLICE_PORT=8000
USER 10001
EXPOSE 8000
HEALTHCHECK --interval=10s --timeout=3s --start-period=20s \
    CMD ["python", "-c", "import urllib.request; urllib.request.urlopen('http://127.0.0.1:8000/readyz', timeout=2)"]
ENTRYPOINT ["motionsplice"]
CMD ["serve", "/bank"]
