# Keypose without the page, to track many sessions:
#
#   docker build --tag keypose .
#   docker run --rm --volume "$PWD/recordings:/data" keypose
#   docker run --rm --volume "$PWD/recordings:/data" keypose export jump.keypose --format bvh --out .
#
# Written as another user than 1000: add --user "$(id -u):$(id -g)". Loops that were compiled stay
# with --volume keypose-cache:/cache, in a folder of each user's.
#
# The image holds more than Keypose: PyAV's wheel carries FFmpeg (LGPL 3 or later) with x264 and x265
# (GPL 2 or later), and whoever passes the image on passes these on, under their terms.

ARG PYTHON=python:3.13.7-slim-bookworm
FROM ${PYTHON} AS built
WORKDIR /source
COPY . .
RUN pip wheel --no-cache-dir --no-deps --wheel-dir /wheels .

FROM ${PYTHON}
# The very files of requirements.lock, and none that they or a registry would choose by now.
RUN --mount=type=bind,from=built,source=/wheels,target=/wheels \
    --mount=type=bind,source=requirements.lock,target=/requirements.lock \
    pip install --no-cache-dir --require-hashes --only-binary :all: -r /requirements.lock \
    && pip install --no-cache-dir --no-deps /wheels/*.whl \
    && useradd --uid 1000 --create-home keypose \
    && install --directory --owner=keypose /data \
    && install --directory --mode=1777 /cache
ENV PYTHONUNBUFFERED=1
USER 1000
WORKDIR /data
VOLUME ["/data", "/cache"]
ENTRYPOINT ["sh", "-c", "XDG_CACHE_HOME=/cache/$(id -u) exec keypose \"$@\"", "keypose"]
CMD ["batch", "."]
