// asm/termbits.h and not termios.h, which knows a few baud rates only, and not 256000.
#include <asm/termbits.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <grp.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "services/sources/devices/descriptor_connection.hpp"
#include "services/sources/devices/serial_ports.hpp"

namespace crsm {
namespace {

class SerialPort : public DescriptorConnection {
 public:
  explicit SerialPort(int descriptor) : DescriptorConnection(descriptor, "was unplugged, or lost its power") {}

  void SetDataTerminalReady(bool ready) override {
    const int line = TIOCM_DTR;
    ioctl(descriptor(), ready ? TIOCMBIS : TIOCMBIC, &line);  // a pseudo-terminal has none
  }
};

/// The group that may use a port: dialout on Debian.
std::string GroupOf(const std::string& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) return "dialout";
  const group* entry = getgrgid(status.st_gid);
  return entry ? entry->gr_name : "dialout";
}

[[noreturn]] void Refuse(const std::string& path, int error) {
  if (error == ENOENT || error == ENODEV || error == ENXIO) {
    throw DeviceError(fmt::format("there is no {}; {}", path, DescribeSerialPorts(FindSerialPorts())));
  }
  if (error == EACCES || error == EPERM) {
    throw DeviceError(
        fmt::format("no permission for {}: sudo usermod -aG {} $USER, then log in again", path, GroupOf(path)));
  }
  if (error == EBUSY) throw DeviceError(fmt::format("{} is in use by another program", path));
  throw DeviceError(fmt::format("{}: {}", path, std::strerror(error)));
}

/// Whether the port is one, and is set now.
bool MakeRaw(int descriptor, int baud) {
  termios2 settings{};
  if (ioctl(descriptor, TCGETS2, &settings) != 0) return false;
  settings.c_iflag = 0;
  settings.c_oflag = 0;
  settings.c_lflag = 0;
  settings.c_cflag = BOTHER | CS8 | CREAD | CLOCAL;  // without HUPCL: the motor of an RPLidar stays as it was left
  settings.c_ispeed = settings.c_ospeed = static_cast<speed_t>(baud);
  settings.c_cc[VMIN] = 0;
  settings.c_cc[VTIME] = 0;
  return ioctl(descriptor, TCSETS2, &settings) == 0;
}

}  // namespace

std::unique_ptr<Connection> OpenSerialPort(const std::string& path, int baud) {
  const int descriptor = open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) Refuse(path, errno);
  auto port = std::make_unique<SerialPort>(descriptor);
  // For others than root TIOCEXCL alone would do.
  struct flock whole {};
  whole.l_type = F_WRLCK;
  if (fcntl(descriptor, F_SETLK, &whole) != 0 && (errno == EAGAIN || errno == EACCES)) Refuse(path, EBUSY);
  if (!MakeRaw(descriptor, baud)) {
    throw DeviceError(fmt::format("{} cannot be set to {} baud: is it a serial port?", path, baud));
  }
  ioctl(descriptor, TIOCEXCL);
  ioctl(descriptor, TCFLSH, TCIFLUSH);
  return port;
}

}  // namespace crsm
