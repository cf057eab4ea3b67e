#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace tessera {

/// Rows of one kind, either its own, like a vector's, or mapped: then they lie in memory of somebody else, a
/// file for instance, which is kept for as long as this lives. Rows may be written in both cases (whoever
/// maps a file maps it copy-on-write); adding to mapped rows makes them its own first, and a copy is its own.
/// T is plain: bytes of a row in a file are a row.
template <class T>
class Column {
 public:
  Column() = default;
  Column(std::vector<T> rows) : own_(std::move(rows)) { look(); }  // NOLINT: implicit by design
  Column(std::span<T> rows, std::shared_ptr<const void> keeper)
      : data_(rows.data()), size_(rows.size()), keeper_(std::move(keeper)) {}
  Column(const Column& other) : own_(other.begin(), other.end()) { look(); }
  Column(Column&& other) noexcept { swap(other); }
  Column& operator=(Column other) noexcept {
    swap(other);
    return *this;
  }
  ~Column() = default;

  void swap(Column& other) noexcept {
    std::swap(own_, other.own_);
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(keeper_, other.keeper_);
  }

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] bool isMapped() const { return keeper_ != nullptr; }
  [[nodiscard]] T& operator[](std::size_t i) { return data_[i]; }
  [[nodiscard]] const T& operator[](std::size_t i) const { return data_[i]; }
  [[nodiscard]] T& back() { return data_[size_ - 1]; }
  [[nodiscard]] const T& back() const { return data_[size_ - 1]; }
  [[nodiscard]] T* begin() { return data_; }
  [[nodiscard]] T* end() { return data_ + size_; }
  [[nodiscard]] const T* begin() const { return data_; }
  [[nodiscard]] const T* end() const { return data_ + size_; }
  [[nodiscard]] const T* data() const { return data_; }
  [[nodiscard]] std::span<const T> rows() const { return {data_, size_}; }

  void reserve(std::size_t count) {
    changeRows([&](std::vector<T>& rows) { rows.reserve(count); });
  }
  void assign(std::size_t count, const T& row) {
    changeRows([&](std::vector<T>& rows) { rows.assign(count, row); });
  }
  template <class Iterator>
  void append(Iterator first, Iterator last) {
    changeRows([&](std::vector<T>& rows) { rows.insert(rows.end(), first, last); });
  }
  void push_back(const T& row) {
    changeRows([&](std::vector<T>& rows) { rows.push_back(row); });
  }
  void pop_back() {
    changeRows([](std::vector<T>& rows) { rows.pop_back(); });
  }

 private:
  void look() {
    data_ = own_.data();
    size_ = own_.size();
  }
  template <class Change>
  void changeRows(Change change) {
    if (keeper_) {
      own_.assign(begin(), end());
      keeper_ = nullptr;
    }
    change(own_);
    look();
  }

  std::vector<T> own_;
  T* data_ = nullptr;  ///< of own_, or mapped
  std::size_t size_ = 0;
  std::shared_ptr<const void> keeper_;  ///< of what is mapped
};

}  // namespace tessera
