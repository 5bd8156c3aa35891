# Keypose without the page, to track many sessions:
#
#   docker build --tag keypose .
#   docker run --rm --volume "$PWD/recordings:/data" keypose
#   docker run --rm --volume "$PWD/recordings:/data" keypose export jump.keypose --format bvh --out .
#
# Written as another user than 1000: add --user "$(id -u):$(id -g)". Loops that were compiled stay
# with --volume keypose-cache:/cache.

FROM python:3.13-slim AS built
WORKDIR /source
COPY . .
RUN pip wheel --no-cache-dir --no-deps --wheel-dir /wheels .

FROM python:3.13-slim
RUN --mount=type=bind,from=built,source=/wheels,target=/wheels \
    pip install --no-cache-dir /wheels/*.whl \
    && useradd --uid 1000 --create-home keypose \
    && install --directory --owner=keypose /data \
    && install --directory --mode=1777 /cache
ENV PYTHONUNBUFFERED=1 XDG_CACHE_HOME=/cache
USER 1000
WORKDIR /data
VOLUME ["/data", "/cache"]
ENTRYPOINT ["keypose"]
CMD ["batch", "."]
