#include "services/run_stack/stack_viewer.hpp"

#include <fmt/core.h>
#include <signal.h>

#include <algorithm>
#include <string_view>
#include <thread>

#include "services/base/process.hpp"

namespace crsm {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr milliseconds kLookAtViewerEvery(20);
constexpr seconds kViewerPatience(10);
constexpr std::string_view kSays = "map_viewer: ";

/// The lines of a log that name an address, without the name of the program.
std::vector<std::string> ReadAddresses(const Member& member) {
  constexpr std::string_view kScheme = "http://";
  std::vector<std::string> addresses;
  std::ifstream file = OpenLog(member.plan.command.log);
  file.seekg(static_cast<std::streamoff>(member.log_begin));
  for (std::string line; std::getline(file, line) && !file.eof();) {  // a line that is not whole yet comes later
    if (line.starts_with(kSays) && std::string_view(line).substr(kSays.size()).starts_with(kScheme)) {
      addresses.push_back(line.substr(kSays.size()));
    }
  }
  return addresses;
}

/// The lines of a code, which begin with its light margin.
std::vector<std::string> ReadQrCode(const Member& member) {
  std::vector<std::string> code;
  std::ifstream file = OpenLog(member.plan.command.log);
  file.seekg(static_cast<std::streamoff>(member.log_begin));
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("\u2588") || line.starts_with("\u2580")) code.push_back(line);
  }
  return code;
}

/// Of "http://127.0.0.1:8765/#token=ab" or "http://[::1]:8765/".
std::string PortOf(const std::string& address) {
  const auto end = address.find('/', std::string_view("http://").size());
  const auto colon = address.rfind(':', end);
  return address.substr(colon + 1, end - colon - 1);
}

}  // namespace

StackViewer::StackViewer(const PlannedService& plan) : member_{plan} {
  const auto give_up = Clock::now() + kViewerPatience;
  member_.Start(plan.when_new);
  while (!member_.IsReady() && member_.IsRunning() && !StopRequested() && Clock::now() < give_up) {
    std::this_thread::sleep_for(kLookAtViewerEvery);
  }
  SayAddresses();
  for (const std::string& line : ReadQrCode(member_)) Say(line);
}

void StackViewer::SayAddresses() {
  const std::vector<std::string> addresses = ReadAddresses(member_);
  if (addresses.empty()) return;
  address_ = addresses.front().substr(0, addresses.front().find(' '));
  http() = http().substr(0, http().rfind(':') + 1) + PortOf(address_);
  for (const std::string& address : addresses) {
    if (said_.insert(address.substr(0, address.find(' '))).second) {
      Say(fmt::format("run_stack: the map is at {}", address));
    }
  }
}

void StackViewer::ShowFinished(const std::filesystem::path& out, Signals& signals) {
  const int num_interrupts = signals.num_interrupts();
  const auto IsInterrupted = [&] { return signals.num_interrupts() != num_interrupts; };
  member_.plan.command.arguments = {out.string(), "--http", http()};
  member_.Start();
  while (!member_.IsReady() && member_.IsRunning() && !IsInterrupted()) signals.Wait(kLookAtViewerEvery);
  if (member_.IsRunning() && !IsInterrupted()) {
    const std::vector<std::string> addresses = ReadAddresses(member_);
    if (!addresses.empty()) address_ = addresses.front().substr(0, addresses.front().find(' '));
    Say(fmt::format("run_stack: the map stays at {} until Ctrl-C", address_));
  }
  while (member_.IsRunning() && !IsInterrupted()) signals.Wait(seconds(1));
  if (member_.HasEnded()) {
    Say(fmt::format("run_stack: map_viewer failed ({}): the finished map is not shown", member_.child->DescribeEnd()));
    return SayLastLines(member_.plan.command.log);
  }
  member_.child->Signal(SIGTERM);
  const auto give_up = Clock::now() + kViewerPatience;
  const int num_then = signals.num_interrupts();
  while (member_.IsRunning() && signals.num_interrupts() == num_then && Clock::now() < give_up) {
    signals.Wait(kLookAtViewerEvery);
  }
  member_.child->Signal(SIGKILL);  // where it has not heeded the first one
}

/// The value of its flag.
std::string& StackViewer::http() {
  auto& arguments = member_.plan.command.arguments;
  return *(std::find(arguments.begin(), arguments.end(), "--http") + 1);
}

}  // namespace crsm
