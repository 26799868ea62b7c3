# One image with one binary, `webloop`, which has every role. Dependencies are a layer of
# their own: it is built again when a Cargo.toml or Cargo.lock changes, and not for a source.
# Left out: tests, and a shaped link, which needs more rights than this image is run with.

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
# A profiler's line tables are most of the binary; nobody profiles in this image.
ENV CARGO_PROFILE_RELEASE_DEBUG=false \
    CARGO_PROFILE_RELEASE_STRIP=true
COPY --from=manifests /webloop .
RUN cargo build --release --locked
COPY . .
# A source may be older than its stand-in, and cargo compares times.
RUN find netem orchestrator services -name '*.rs' -exec touch {} + \
    && cargo build --release --locked

FROM debian:bookworm-slim
LABEL org.opencontainers.image.title="webloop" \
      org.opencontainers.image.description="Real control loops over real HTTP, across links that behave like real networks" \
      org.opencontainers.image.licenses="MIT"
COPY --from=build /webloop/target/release/webloop /usr/local/bin/webloop
COPY LICENSE /usr/share/doc/webloop/LICENSE
# Without a name, since it needs no home. Give another one to write into a folder of theirs.
USER 1000:1000
ENTRYPOINT ["webloop"]
