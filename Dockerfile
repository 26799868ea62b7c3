# Images with the same one binary, `webloop`, which has every role:
#
#   webloop            that binary alone, a few MB: plant and orchestrator
#   webloop-link       beside tc of iproute2, for the sidecars that shape a link
#   webloop-native     nothing more than the first: the controller, by client
#   webloop-python     beside Python
#   webloop-chromium   beside Chromium
#   webloop-firefox    beside Firefox
#   webloop-own        put into an image of somebody's own, named by the argument OWN
#
# Dependencies are a layer of their own: it is built again when a Cargo.toml or Cargo.lock
# changes, and not for a source. Builds with BuildKit and with the classic builder.
# Left out: tests.
#
# Debian's packages have no versions here (hadolint's DL3008): a release of Debian changes them for security
# alone, and keeps none of the older ones, so that a version would end with the next fix.

# None, so that the other targets need no image of anybody's.
ARG OWN=webloop

FROM rust:1-slim-bookworm AS manifests
WORKDIR /webloop
COPY . .
# Each manifest, and the least source that it builds with. What is copied from here is
# compared by content, so other changes to a source end here.
RUN find . -type f ! -name Cargo.toml ! -name Cargo.lock ! -name lib.rs ! -name main.rs -delete \
    && find . -name '*.rs' -exec sed -i '1!d; s/.*/fn main() { }/' {} + \
    && find . -type d -empty -delete

FROM rust:1-slim-bookworm AS build
WORKDIR /webloop
# A profiler's line tables are most of the binary; nobody profiles in these images.
# Linked with nothing left to load, the binary runs in an image that has no other file. The C
# library still finds host names there: it asks the resolver of /etc/resolv.conf by itself.
ENV CARGO_PROFILE_RELEASE_DEBUG=false \
    CARGO_PROFILE_RELEASE_STRIP=true \
    RUSTFLAGS="-C target-feature=+crt-static"
COPY --from=manifests /webloop .
# With a target named, the flags are for that target and not for macros, which are loaded.
RUN cargo build --release --locked --package webloop --target "$(rustc --print host-tuple)"
COPY . .
# A source may be older than its stand-in, and cargo compares times.
RUN find base netem orchestrator services -name '*.rs' -exec touch {} + \
    && cargo build --release --locked --package webloop --target "$(rustc --print host-tuple)" \
    && mv target/*/release/webloop /usr/local/bin/webloop

# Before the other one, whose build then finds all but its own last steps done.
FROM scratch AS webloop
LABEL org.opencontainers.image.title="webloop" \
      org.opencontainers.image.description="Real control loops over real HTTP, across links that behave like real networks" \
      org.opencontainers.image.licenses="MIT"
COPY --from=build /usr/local/bin/webloop /usr/local/bin/webloop
COPY LICENSE /usr/share/doc/webloop/LICENSE
# Without a name, since it needs no home. Give another one to write into a folder of theirs.
USER 1000:1000
ENTRYPOINT ["webloop"]

# `tc` with the libraries that it loads, and nothing else of Debian.
FROM debian:bookworm-slim AS tc
SHELL ["/bin/bash", "-o", "pipefail", "-c"]
# hadolint ignore=DL3008
RUN apt-get update \
    && apt-get install --yes --no-install-recommends iproute2 \
    && mkdir /only \
    && ldd /sbin/tc | grep --only-matching '/[^ ]*' | xargs cp --dereference --parents --target-directory=/only \
        /sbin/tc /usr/share/doc/iproute2/copyright

FROM webloop AS webloop-link
LABEL org.opencontainers.image.title="webloop-link" \
      org.opencontainers.image.description="Shapes one end's way out of a control loop, for webloop"
COPY --from=tc /only /
# Interfaces are changed by root alone; docker-compose.yml takes all but two of its powers.
# hadolint ignore=DL3002
USER 0:0

FROM webloop AS webloop-native

FROM debian:bookworm-slim AS webloop-python
LABEL org.opencontainers.image.title="webloop-python" \
      org.opencontainers.image.description="The paper's Python controller, for webloop" \
      org.opencontainers.image.licenses="MIT"
# hadolint ignore=DL3008
RUN apt-get update \
    && apt-get install --yes --no-install-recommends python3 \
    && rm -rf /var/lib/apt/lists/* /var/cache/apt/*
COPY --from=build /usr/local/bin/webloop /usr/local/bin/webloop
COPY LICENSE /usr/share/doc/webloop/LICENSE
USER 1000:1000
ENTRYPOINT ["webloop"]

# A browser that finds no font at all takes seconds to start.
FROM debian:bookworm-slim AS webloop-chromium
LABEL org.opencontainers.image.title="webloop-chromium" \
      org.opencontainers.image.description="A controller in Chromium, for webloop" \
      org.opencontainers.image.licenses="MIT"
# hadolint ignore=DL3008
RUN apt-get update \
    && apt-get install --yes --no-install-recommends chromium fonts-dejavu-core \
    && rm -rf /var/lib/apt/lists/* /var/cache/apt/*
COPY --from=build /usr/local/bin/webloop /usr/local/bin/webloop
COPY LICENSE /usr/share/doc/webloop/LICENSE
USER 1000:1000
ENTRYPOINT ["webloop"]

FROM debian:bookworm-slim AS webloop-firefox
LABEL org.opencontainers.image.title="webloop-firefox" \
      org.opencontainers.image.description="A controller in Firefox, for webloop" \
      org.opencontainers.image.licenses="MIT"
# hadolint ignore=DL3008
RUN apt-get update \
    && apt-get install --yes --no-install-recommends firefox-esr fonts-dejavu-core \
    && rm -rf /var/lib/apt/lists/* /var/cache/apt/*
COPY --from=build /usr/local/bin/webloop /usr/local/bin/webloop
COPY LICENSE /usr/share/doc/webloop/LICENSE
USER 1000:1000
ENTRYPOINT ["webloop"]

# It keeps what that image starts by itself; webloop is started by name.
FROM ${OWN} AS webloop-own
COPY --from=build /usr/local/bin/webloop /usr/local/bin/webloop
COPY LICENSE /usr/share/doc/webloop/LICENSE
