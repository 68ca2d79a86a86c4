// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Text that contains numbers. Internal to packMesh/io.
#pragma once

#include <charconv>
#include <string>

#include "packMesh/core/vector.h"

namespace packmesh {

/// Writes numbers with enough digits to be read back exactly, independently of the locale.
class ExactText {
 public:
  ExactText& operator<<(const char* text) { return text_ += text, *this; }
  ExactText& operator<<(const std::string& text) { return text_ += text, *this; }
  ExactText& operator<<(double value) { return number(value); }
  ExactText& operator<<(int value) { return number(value); }
  ExactText& operator<<(std::size_t value) { return number(value); }
  ExactText& operator<<(const Vec3& p) { return *this << p.x() << " " << p.y() << " " << p.z(); }
  const std::string& str() const { return text_; }

 private:
  template <class T>
  ExactText& number(T value) {
    char digits[40];
    text_.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
    return *this;
  }
  std::string text_;
};

}  // namespace packmesh
