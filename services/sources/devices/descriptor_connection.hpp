#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include "services/sources/devices/connection.hpp"

namespace crsm {

/// A connection that is a file descriptor which does not block.
class DescriptorConnection : public Connection {
 public:
  /// Takes the descriptor over. gone: what to say when the other side is.
  DescriptorConnection(int descriptor, std::string gone) : descriptor_(descriptor), gone_(std::move(gone)) {}
  ~DescriptorConnection() override;
  DescriptorConnection(const DescriptorConnection&) = delete;

  std::string Read(std::chrono::milliseconds longest) override;
  void Write(std::string_view bytes) override;

 protected:
  int descriptor() const { return descriptor_; }

 private:
  /// Whether the descriptor has become ready for `events` of poll().
  bool Await(short events, std::chrono::milliseconds longest) const;

  int descriptor_;
  std::string gone_;
};

}  // namespace crsm
