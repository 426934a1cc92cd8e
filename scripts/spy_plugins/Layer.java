package crsm.spy;

/** What a map view draws, each to be switched off. */
enum Layer {
  GRID("Grid", "a grid, and how long its lines are apart"),
  PATH("Path", "where the laser was, as far as the map's owner knows by now"),
  HITS("Hits", "what the last scan saw, at the pose that was found for it"),
  CRITICAL_RAYS("Critical rays", "the rays that were matched, in colour by what the map has where they end"),
  UNCERTAINTY("Uncertainty", "an ellipse of three standard deviations; and the axis along which nothing holds"),
  TEXT("Text", "state, pose, and what the colours mean");

  final String title;
  final String help;

  Layer(String title, String help) {
    this.title = title;
    this.help = help;
  }
}
