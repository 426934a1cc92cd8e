// map_viewer: what the others say -> a page in a browser, and Foxglove. All that it says on the bus: it asks for the
// map as an exporter does, and tells a robot that is localised where it is, when somebody points there. All that it
// writes: edits of a finished map, beside it.

#include <fmt/core.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <deque>
#include <future>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/logs/stop_request.hpp"
#include "services/base/process.hpp"
#include "services/base/usage_error.hpp"
#include "services/base/viewer_token.hpp"
#include "services/journal/run_folder.hpp"
#include "services/map_viewer/access.hpp"
#include "services/map_viewer/finished_run.hpp"
#include "services/map_viewer/history.hpp"
#include "services/map_viewer/links.hpp"
#include "services/map_viewer/live_robot.hpp"
#include "services/map_viewer/map_editor.hpp"
#include "services/map_viewer/mcap_export.hpp"
#include "services/map_viewer/qr_code.hpp"
#include "services/map_viewer/site.hpp"
#include "services/map_viewer/web_server.hpp"
#include "services/settings/command_line.hpp"

namespace crsm {
namespace {

struct ViewerOptions {
  std::vector<std::string> folders;
  std::vector<std::string> robots;
  std::string mcap;
  bool qr_code = false;
};

/// A token that was handed over stays valid when a viewer is started again. Empty where none is needed.
std::string ChooseToken(const HttpAddress& address) {
  const auto given = ReadViewerToken();
  return address.is_loopback ? "" : given.value_or(DrawViewerToken());
}

/// Scenes behind an address, which is said on stderr.
class Window {
 public:
  Window(const CommandLine& command_line, const ViewerOptions& options, std::vector<const Scene*> scenes,
         std::vector<ShownPiece> pieces, Counters& counters)
      : address_(ParseHttpAddress(command_line.settings().http)),
        token_(ChooseToken(address_)),
        site_(std::move(scenes), Access(address_.is_loopback, token_), options.folders, std::move(pieces)),
        server_(
            address_, [this](const WebRequest& request) { return site_.Answer(request); }, counters) {
    const bool is_another_port = address_.port != 0 && server_.address().port != address_.port;
    const std::vector<std::string> links = MakeLinks(server_.address(), token_, ListInterfaceAddresses());
    for (const std::string& link : links) {
      Say(fmt::format("{}: {}{}", command_line.program(), link,
                      is_another_port ? fmt::format(" (port {} is in use)", address_.port) : ""));
    }
    if (!token_.empty()) {
      Say(fmt::format("{}: to look, and change nothing: {}", command_line.program(),
                      MakeLinks(server_.address(), ToLookToken(token_), ListInterfaceAddresses()).front()));
    }
    if (address_.is_loopback || !(options.qr_code || isatty(STDERR_FILENO))) return;
    for (const std::string& line : DrawQrCode(links.front())) Say(line);
  }

  WebServer& server() { return server_; }

 private:
  HttpAddress address_;
  std::string token_;
  Site site_;
  WebServer server_;
};

/// A robot beside others: the same command line, but for its channel prefix.
std::unique_ptr<CommandLine> ForRobot(const CommandLine& command_line, const std::string& channel_prefix) {
  ProgramFlags others = FlagsOfViewer();
  std::erase(others.settings, "channel_prefix");
  std::vector<std::string> words = command_line.WordsFor(others);
  words.insert(words.begin(), command_line.program());
  words.insert(words.end(), {"--channel-prefix", channel_prefix});
  std::vector<const char*> argv;
  for (const std::string& word : words) argv.push_back(word.c_str());
  auto of_robot = std::make_unique<CommandLine>(command_line.program(), "", FlagsOfViewer());
  if (of_robot->Parse(static_cast<int>(argv.size()), argv.data())) throw UsageError("--robots: no such robot");
  return of_robot;
}

void ShowLive(const CommandLine& command_line, const ViewerOptions& options) {
  // Messages gather for as long while clients are served: to wake up for each alone costs more than to handle it.
  constexpr auto kGatherFor = std::chrono::milliseconds(8);
  constexpr int kPageWait_ms = 5;
  std::deque<std::unique_ptr<CommandLine>> command_lines;
  std::deque<LiveRobot> robots;
  std::vector<const Scene*> scenes;
  const bool are_several = !options.robots.empty();
  for (const std::string& prefix : are_several ? options.robots : std::vector{command_line.settings().channel_prefix}) {
    command_lines.push_back(ForRobot(command_line, prefix));
    robots.emplace_back(*command_lines.back());
    robots.back().service().SetState("showing");
    scenes.push_back(&robots.back().scene());
  }
  Window window(command_line, options, std::move(scenes), {}, robots.front().service().counters());
  robots.front().service().Run(
      [&] {
        bool is_fetching = false;
        for (LiveRobot& robot : robots) {
          if (&robot != &robots.front()) robot.service().Spin(0);
          robot.Step(window.server().num_feeds() > 0);
          is_fetching = is_fetching || robot.is_fetching();
        }
        window.server().Serve(is_fetching ? std::chrono::milliseconds(0) : kGatherFor);
        return is_fetching;
      },
      kPageWait_ms);
}

/// The history of a run, read in a thread while the run is shown already.
class ComingHistory {
 public:
  explicit ComingHistory(Scene& scene)
      : scene_(scene), history_(std::async(std::launch::async, [&scene]() -> std::shared_ptr<const History> {
          constexpr int kNice = 10;
          setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);  // those who look go first
          try {
            return ReadHistory(scene, StopRequested);
          } catch (const std::exception&) {  // the page shows what the run has come to
            return nullptr;
          }
        })) {}

  /// Shows it when it is there.
  void Step() {
    if (history_.valid() && history_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
      scene_.SetHistory(history_.get());
    }
  }

 private:
  Scene& scene_;
  std::future<std::shared_ptr<const History>> history_;
};

void ShowFinished(const CommandLine& command_line, const ViewerOptions& options) {
  constexpr auto kLookForSignals = std::chrono::milliseconds(100);
  for (const char* setting : {"lcm_url", "channel_prefix"}) {
    if (command_line.WasGiven(setting)) {
      throw UsageError(fmt::format("{}: applies to live robots only; remove it for a finished run", FlagOf(setting)));
    }
  }
  std::vector<std::map<int, std::unique_ptr<Scene>>> runs;
  std::vector<const Scene*> scenes;
  std::vector<ShownPiece> pieces;
  std::deque<MapEditor> editors;
  for (const std::string& folder : options.folders) {
    runs.push_back(ReadFinishedRun(folder));
    scenes.push_back(runs.back().at(FindRun(folder).piece).get());
    for (const auto& [piece, scene] : runs.back()) {
      pieces.push_back({runs.size() - 1, piece, scene.get()});
      editors.emplace_back(scene->name(), *scene);
    }
  }
  Counters counters;
  Window window(command_line, options, std::move(scenes), std::move(pieces), counters);
  CatchSignals();
  Say(command_line.program() + ": ready");
  std::deque<ComingHistory> histories;
  for (const auto& run : runs) {
    if (run.contains(1)) histories.emplace_back(*run.at(1));
  }
  while (!StopRequested()) {
    window.server().Serve(kLookForSignals);
    for (MapEditor& editor : editors) editor.Step();
    for (ComingHistory& history : histories) history.Step();
  }
}

void Show(const CommandLine& command_line, const ViewerOptions& options) {
  if (!options.folders.empty() && !options.robots.empty()) {
    throw UsageError("--robots: shows live robots; remove it for a finished run");
  }
  if (!options.mcap.empty()) {
    if (options.folders.size() != 1) throw UsageError("--mcap: needs the DIR of one finished run");
    return WriteMcap(options.folders.front(), options.mcap);
  }
  options.folders.empty() ? ShowLive(command_line, options) : ShowFinished(command_line, options);
}

}  // namespace
}  // namespace crsm

int main(int argc, char** argv) {
  crsm::CommandLine command_line("map_viewer",
                                 "Shows the growing map in a browser, and in Foxglove and Lichtblick on the same port.",
                                 crsm::FlagsOfViewer());
  crsm::ViewerOptions options;
  command_line.AddOptionalWords(
      "DIR", options.folders,
      "folders (--out) of finished runs, shown side by side; without one, the live robot is shown");
  command_line.AddOption("--robots", options.robots,
                         "channel prefixes of several robots on one bus, shown side by side: robot1/ robot2/");
  command_line.AddOption("--mcap", options.mcap,
                         "write the run in DIR as an MCAP file for Foxglove and Lichtblick, and exit");
  command_line.AddFlag("--qr-code", options.qr_code,
                       "draw the link that other hosts can use as a QR code, also where stderr is no terminal");
  if (const auto exit_code = command_line.Parse(argc, argv)) return *exit_code;
  return crsm::RunMain(command_line.program(), [&] { crsm::Show(command_line, options); });
}
