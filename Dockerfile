# The program alone, static, in an otherwise empty image:
#
#   docker build --tag isomend .
#   docker run --rm --volume "$PWD:/work" isomend fill scan.ply -o mended.glb
FROM rust:1.88-slim AS build
RUN apt-get update && apt-get install -y --no-install-recommends gcc libc6-dev && rm -rf /var/lib/apt/lists/*
WORKDIR /source
COPY Cargo.toml Cargo.lock README.md ./
COPY src src
COPY crates crates
COPY benches benches
COPY fuzz fuzz
COPY python python
COPY docs docs
RUN target=$(rustc -vV | sed -n 's/^host: //p') \
    && RUSTFLAGS="-C target-feature=+crt-static" cargo build --locked --profile dist --package isomend --target "$target" \
    && cp "target/$target/dist/isomend" /isomend

FROM scratch
COPY --from=build /isomend /isomend
WORKDIR /work
ENTRYPOINT ["/isomend"]
