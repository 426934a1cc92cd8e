#pragma once

#include <optional>
#include <string>

#include "common/parameters.hpp"

namespace crsm {

/// What a process is told besides the parameters of the algorithm.
struct Settings {
  std::string lcm_url;
  std::string channel_prefix;
  std::string out;
  std::string rate = "1";
  std::string laser_channel;
  std::string position;
  bool lockstep = false;
  double map_wait_s = 0.2;
  double resend_s = 0.05;
  std::string journal;
  bool resume = false;
  bool until_damage = false;
  std::string localize;
  std::string start;
  int part_bytes = 32000;
  double export_period_s = 5.0;
  std::string http = "127.0.0.1:8765";
};

/// The one list of all settings, as VisitParameters is of the parameters.
template <class Visitor>
void VisitSettings(Settings& s, Visitor&& visit) {
  visit("lcm_url", "where messages go; the environment's LCM_DEFAULT_URL or LCM's own default if empty", s.lcm_url);
  visit("channel_prefix", "before every channel name, e.g. robot1/", s.channel_prefix);
  visit("out", "folder for the results", s.out);
  visit("rate", "1: as fast as it was recorded, N: N times that, max: as fast as the map is made, nothing lost",
        s.rate);
  visit("laser_channel",
        "or topic, of the laser; if empty: of an LCM log the first that has one, of a bag the only one, live LASER",
        s.laser_channel);
  visit("position", "file that keeps how many scans were published; where it is there, goes on behind them",
        s.position);
  visit("lockstep", "wait for whatever is missing, instead of going on without it", s.lockstep);
  visit("map_wait_s", "without --lockstep: longest wait for the map of the last scan [s]", s.map_wait_s, 0.0, 60.0);
  visit("resend_s", "rate max: a scan is sent again when its map has not come by then [s]", s.resend_s, 0.01, 60.0);
  visit("journal", "folder in which every scan that is mapped is kept, so that the map can be made again", s.journal);
  visit("resume", "begin with the map of the journal", s.resume);
  visit("until_damage", "of a journal that is damaged in the middle, take the map up to there", s.until_damage);
  visit("localize", "folder of an earlier run (its --out): localise on its map, which stays as it is", s.localize);
  visit("start", "X,Y,YAW of the laser on a finished map [m, m, rad]; searched on all of it if empty", s.start);
  visit("part_bytes", "largest MAP_DELTA [bytes], but a tile stays whole; about 1400 on a network that loses packets",
        s.part_bytes, 200, 48000);
  visit("export_period_s", "between two writings of the results [s]", s.export_period_s, 0.1, 3600.0);
  visit("http", "ADDRESS:PORT on which map_viewer shows the map; beyond this host only to who has its token", s.http);
}

/// The factor to real time that a rate says, 0 for max: as fast as scans are mapped. Throws UsageError if it says none.
double ParseRate(const std::string& text);

/// X,Y,YAW; nothing where there is no text. Throws UsageError if it is something else.
std::optional<Pose2> ParseStart(const std::string& text);

}  // namespace crsm
