#!/usr/bin/env bash
# Installs what SEAM is built with, by package name, on Debian 12. Quick when all is there.
set -euo pipefail
packages=(
  build-essential clang-format cmake ninja-build ccache mold pkg-config git ca-certificates python3
  python3-grpcio python3-protobuf python3-numpy python3-pil python3-jsonschema python3-yaml
  libgrpc++-dev libprotobuf-dev protobuf-compiler protobuf-compiler-grpc libssl-dev openssl
  libyaml-cpp-dev libfmt-dev libcli11-dev nlohmann-json3-dev libmuparser-dev
  libglm-dev libeigen3-dev libbox2d-dev libsleef-dev librandom123-dev libxxhash-dev
  libboost-math-dev libpng-dev libjpeg-dev libtiff-dev libosmesa6-dev libegl-dev libgl1-mesa-dri libassimp-dev libtinyxml2-dev libapriltag-dev libzstd-dev
  libopencv-contrib-dev libexif-dev liblz4-dev libbz2-dev zlib1g-dev libsqlite3-dev libcpp-httplib-dev libgtest-dev libgmock-dev
  libbenchmark-dev
  gnuplot-nox nodejs npm chromium fonts-dejavu-core iproute2 procps file
)
missing=()
for package in "${packages[@]}"; do
  case "$package" in  # Another vendor's node or npm serves as well.
    nodejs) command -v node >/dev/null && continue ;;
    npm) command -v npm >/dev/null && continue ;;
  esac
  [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0
echo "Installing: ${missing[*]}"
sudo=()
[ "$(id -u)" -eq 0 ] || sudo=(sudo)
"${sudo[@]}" apt-get update -q
DEBIAN_FRONTEND=noninteractive "${sudo[@]}" apt-get install -y -q --no-install-recommends "${missing[@]}"
