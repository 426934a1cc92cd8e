#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "services/map_viewer/access.hpp"
#include "services/map_viewer/run_files.hpp"
#include "services/map_viewer/scene.hpp"
#include "services/map_viewer/web_server.hpp"

namespace crsm {

/// A piece of the map of a finished run.
struct ShownPiece {
  std::size_t robot = 0;  ///< number of the run
  int piece = 1;
  const Scene* scene = nullptr;
};

/// What is at which address: the page and its files, what feeds the page, and what feeds Foxglove.
class Site {
 public:
  /// scenes: one for each robot; they and those of the pieces outlive the site and its feeds. folders: of finished
  /// runs, one for each scene; none where robots are live.
  Site(std::vector<const Scene*> scenes, Access access, std::vector<std::string> folders = {},
       std::vector<ShownPiece> pieces = {});

  WebAnswer Answer(const WebRequest& request) const;

 private:
  WebAnswer AnswerFiles(const WebRequest& request) const;
  WebAnswer AnswerUpgrade(const WebRequest& request) const;
  std::optional<std::size_t> FindScene(const WebRequest& request) const;
  bool AllowsTokenOf(const WebRequest& request) const;
  std::vector<std::string> Prefixes() const;
  std::unique_ptr<Feed> MakeFoxgloveFeed() const;

  std::vector<const Scene*> scenes_;  ///< of robots, then of pieces
  std::size_t num_robots_;
  std::vector<ShownPiece> pieces_;
  Access access_;
  std::unique_ptr<RunFiles> files_;
};

}  // namespace crsm
