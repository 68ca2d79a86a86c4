// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file An open file of the system, closed at the end of its scope.
#pragma once

namespace packmesh {

/// Owns a file descriptor; a negative number is none.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept;
  Descriptor& operator=(Descriptor&& other) noexcept;
  ~Descriptor() { close(); }

  int number() const { return number_; }
  bool isOpen() const { return number_ >= 0; }
  void close();
  /// Moves it to the first free number that is not below `least`; closed in programs that are started.
  /// @return false, with errno, if there is none
  bool raise(int least);

 private:
  int number_ = -1;
};

}  // namespace packmesh
