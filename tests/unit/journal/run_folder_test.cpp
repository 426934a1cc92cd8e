#include "services/journal/run_folder.hpp"

#include <fstream>

#include "catch.hpp"
#include "scratch.hpp"
#include "services/map_viewer/run_facts.hpp"
#include "services/map_viewer/run_files.hpp"

namespace crsm {
namespace {

void Write(const std::filesystem::path& file) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file) << "x";
}

}  // namespace

TEST_CASE("a piece is found by its folder, whose run has the journal") {
  const ScratchFolder folder;
  const std::filesystem::path run = folder.path() / "run";
  for (const char* name : {"pieces/12", "pieces/12/", "pieces/../pieces/12/."}) {
    CAPTURE(name);
    const RunFolder found = FindRun(run / name);
    CHECK((found.run == run && found.piece == 12));
  }
  for (const char* name :
       {"", "pieces", "pieces/1", "pieces/0", "pieces/-2", "pieces/two", "parts/2", "pieces/2/journal"}) {
    CAPTURE(name);
    const RunFolder found = FindRun(run / name);
    CHECK((found.run == run / name && found.piece == 1));
  }
  Write(run / "pieces/2/journal/journal.lcm");  // a run that somebody keeps there
  CHECK(FindRun(run / "pieces/2").piece == 1);
}

TEST_CASE("pieces are listed with the folders that they have") {
  const ScratchFolder folder;
  MapPieces pieces;
  pieces.pieces = {{50, 400, 30.5}, {20, 100, 8.0}, {2, 9, 0.5}};
  for (const char* file : {"map.png", "pieces/2/map.png"}) Write(folder / file);
  const auto list = ListPieces(folder.path(), pieces);
  REQUIRE(list.size() == 3);
  CHECK(list[0] == nlohmann::json{{"piece", 1}, {"scans", 400}, {"way_m", 30.5}, {"folder", folder.path().string()}});
  CHECK(list[1]["folder"] == (folder / "pieces/2").string());
  CHECK_FALSE(list[2].contains("folder"));
  const auto facts = DescribePiece({folder.path(), 2}, pieces);
  CHECK((facts["verdict"]["trust"] == "none" && facts["way_m"] == 8.0));
}

TEST_CASE("a piece has files, but nothing to make run.mcap of") {
  const ScratchFolder folder;
  for (const char* file : {"map.png", "pieces/2/map.png"}) Write(folder / file);
  const RunFiles files({folder.path().string(), (folder / "pieces/2").string()});
  CHECK(nlohmann::json::parse(files.List(0).body).size() == 2);
  const auto of_piece = nlohmann::json::parse(files.List(1).body);
  REQUIRE(of_piece.size() == 1);
  CHECK(of_piece[0]["name"] == "map.png");
}

}  // namespace crsm
