#pragma once

#include <chrono>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

namespace crsm {

/// Why no scans come from a laser, and what mends it: one line. Passes by itself where somebody mends it.
class DeviceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// ... in particular that nothing, or nothing that could be understood, was answered: maybe at another baud rate.
class NoAnswer : public DeviceError {
 public:
  using DeviceError::DeviceError;
};

/// Bytes to and from a laser.
class Connection {
 public:
  virtual ~Connection() = default;

  /// What has come, after `longest` at most; empty if nothing has. Throws DeviceError if the other side is gone.
  virtual std::string Read(std::chrono::milliseconds longest) = 0;

  /// Throws DeviceError if they cannot be sent.
  virtual void Write(std::string_view bytes) = 0;

  /// A line of serial ports: Data Terminal Ready. Where there is none, nothing happens.
  virtual void SetDataTerminalReady(bool /*ready*/) {}
};

/// A serial port: raw, 8 bits, no parity, one stop bit. No other process may have it. Throws DeviceError.
std::unique_ptr<Connection> OpenSerialPort(const std::string& path, int baud);

/// A TCP connection, waited for no longer than a second. Throws DeviceError.
std::unique_ptr<Connection> OpenTcp(const std::string& host, const std::string& port);

}  // namespace crsm
