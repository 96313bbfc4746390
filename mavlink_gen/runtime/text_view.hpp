// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

namespace cas::mav {

/// Borrowed characters. It becomes a std::string_view, and is made of one, of a std::string or of a
/// literal, without a word; <string_view> itself would make a header that sends one message a third
/// dearer to compile.
class TextView {
 public:
  constexpr TextView() = default;
  constexpr TextView(const char* characters) : data_(characters) {  // implicit: of a literal
    while (characters[size_] != '\0') ++size_;
  }
  constexpr TextView(const char* data, std::size_t size) : data_(data), size_(size) {}
  template <class Text>
  requires requires(const Text& text) {
    typename Text::traits_type;
    static_cast<const char*>(text.data());
  }
  constexpr TextView(const Text& text) : data_(text.data()), size_(text.size()) {}

  /// As a std::string_view; a std::string wants to be asked for.
  template <class View>
  requires requires(const char* data, std::size_t size) {
    typename View::traits_type;
    View(data, size);
    requires !requires { typename View::allocator_type; };
  }
  constexpr operator View() const { return View(data_, size_); }

  constexpr const char* data() const { return data_; }
  constexpr std::size_t size() const { return size_; }
  constexpr bool empty() const { return size_ == 0; }
  constexpr const char* begin() const { return data_; }
  constexpr const char* end() const { return data_ + size_; }
  constexpr char operator[](std::size_t index) const { return data_[index]; }

  constexpr bool starts_with(TextView text) const {
    return text.size_ <= size_ && TextView(data_, text.size_).same(text);
  }

  /// The same characters. A template, so that no other comparison fits as well.
  template <class Text>
  requires requires(const Text& text) { TextView(text); }
  friend constexpr bool operator==(const TextView& a, const Text& b) { return a.same(TextView(b)); }
  template <class Stream>
  requires requires(Stream& stream, const char* data) { stream.write(data, 1).flush(); }
  friend Stream& operator<<(Stream& stream, const TextView& text) {
    stream.write(text.data_, static_cast<std::ptrdiff_t>(text.size_));
    return stream;
  }

 private:
  constexpr bool same(const TextView& other) const {
    if (size_ != other.size_) return false;
    for (std::size_t i = 0; i < size_; ++i) {
      if (data_[i] != other.data_[i]) return false;
    }
    return true;
  }

  const char* data_ = "";
  std::size_t size_{};
};

}  // namespace cas::mav
