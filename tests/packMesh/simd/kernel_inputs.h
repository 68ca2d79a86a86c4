// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Inputs of kernels that are the same on every processor, and hashes of what they return.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace packmesh {

/// FNV-1a, of values without padding.
class Hash {
 public:
  template <class Value>
  void add(const Value& value) {
    static_assert(std::is_trivially_copyable_v<Value>);
    unsigned char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    for (unsigned char byte : bytes) state_ = (state_ ^ byte) * 0x100000001b3u;
  }
  std::uint64_t value() const { return state_; }

 private:
  std::uint64_t state_ = 0xcbf29ce484222325u;
};

class Random {
 public:
  float between(float lo, float hi) {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return lo + (hi - lo) * (static_cast<float>(state_ >> 40) * 0x1p-24f);
  }
  void direction(float (&v)[3]) {
    float squared = 0.0f;
    while (squared < 0.01f || squared > 1.0f) {
      squared = 0.0f;
      for (float& x : v) {
        x = between(-1.0f, 1.0f);
        squared += x * x;
      }
    }
    for (float& x : v) x /= std::sqrt(squared);
  }
  /// Row by row.
  void rotation(float (&m)[9]) {
    float a[3], b[3];
    direction(a), direction(b);
    // Two reflections.
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) {
        m[3 * r + c] = r == c ? 1.0f : 0.0f;
        m[3 * r + c] -= 2.0f * a[r] * a[c] + 2.0f * b[r] * b[c];
        m[3 * r + c] += 4.0f * (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) * a[r] * b[c];
      }
  }

 private:
  std::uint64_t state_ = 1;
};

}  // namespace packmesh
