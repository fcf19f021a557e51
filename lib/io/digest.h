// Digests of bytes: the wrapper of xxHash.

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace betamesh {

/// 128 bits, the low half first.
using Digest = std::array<std::uint64_t, 2>;

/// The digest of bytes that are added piece by piece.
///
/// same    value for the same bytes, however they are divided
/// source  XXH3 of xxHash, 128 bits
class Digester {
public:
    Digester();
    ~Digester();
    Digester(const Digester&) = delete;

    void add(std::span<const std::byte> bytes);
    Digest value() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

Digest digestOf(std::span<const std::byte> bytes);

}  // namespace betamesh
