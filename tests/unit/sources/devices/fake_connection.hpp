#pragma once

#include <deque>
#include <functional>
#include <string>

#include "services/sources/devices/connection.hpp"

namespace crsm {

/// A laser in the same process: answers each request at once.
class FakeConnection : public Connection {
 public:
  explicit FakeConnection(std::function<std::string(const std::string&)> answer) : answer_(std::move(answer)) {}

  std::string Read(std::chrono::milliseconds) override { return std::exchange(waiting_, ""); }
  void Write(std::string_view bytes) override {
    requests_.emplace_back(bytes);
    waiting_ += answer_(requests_.back());
  }
  void SetDataTerminalReady(bool ready) override { ready_ = ready; }

  const std::deque<std::string>& requests() const { return requests_; }
  bool ready() const { return ready_; }

 private:
  std::function<std::string(const std::string&)> answer_;
  std::deque<std::string> requests_;
  std::string waiting_;
  bool ready_ = true;
};

}  // namespace crsm
