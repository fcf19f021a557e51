#include "io/digest.h"

#include <new>

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace betamesh {

namespace {

Digest halvesOf(const XXH128_hash_t& hash) { return {hash.low64, hash.high64}; }

}  // namespace

struct Digester::State {
    std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> hash{XXH3_createState(), &XXH3_freeState};
};

Digester::Digester() : state_(std::make_unique<State>()) {
    if (!state_->hash) throw std::bad_alloc();
    XXH3_128bits_reset(state_->hash.get());
}

Digester::~Digester() = default;

void Digester::add(std::span<const std::byte> bytes) {
    XXH3_128bits_update(state_->hash.get(), bytes.data(), bytes.size());
}

Digest Digester::value() const { return halvesOf(XXH3_128bits_digest(state_->hash.get())); }

Digest digestOf(std::span<const std::byte> bytes) { return halvesOf(XXH3_128bits(bytes.data(), bytes.size())); }

}  // namespace betamesh
