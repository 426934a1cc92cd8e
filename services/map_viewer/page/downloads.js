// What a run that has ended has left, to be saved.

const WHAT = {
  "map.png": "map, a pixel a cell", "map.yaml": "for map_server, beside map.png", "map.pgm": "map, for tools that read no PNG",
  "overview.png": "map, path and legend", "trajectory.tum": "pose of each scan", "graph.g2o": "pose graph",
  "changes.csv": "what has come and gone", "summary.json": "figures and verdict",
  "marks.csv": "places", "marks.geojson": "places", "map.tif": "GeoTIFF for RoboCup Rescue",
  "keepout.png": "zones to keep out of", "keepout.yaml": "for map_server",
  "slow.png": "slow zones", "slow.yaml": "for map_server", "map_edited.tar": "edited map, for map_server",
  "run.mcap": "for Foxglove; it takes a while to be made",
};

const size = (bytes) =>
  bytes === null ? "" : bytes < 1e5 ? `${Math.ceil(bytes / 1000)} kB` : `${(bytes / 1e6).toFixed(1)} MB`;

// Asks the viewer once for each run.
export async function showDownloads({model, connection}) {
  const list = document.getElementById("files");
  const run = model.info.live === false ? `${connection.robot} ${model.info.robot} ${model.info.edits?.state}` : "";
  if (list.dataset.run === run) return;
  list.dataset.run = run;
  list.replaceChildren();
  if (!run) return;
  const query = connection.query();
  const answer = await fetch(`files?${query}`);
  const files = answer.ok ? await answer.json() : [];
  list.replaceChildren(...files.map(({name, bytes}) => {
    const link = document.createElement("a");
    link.href = `files/${encodeURIComponent(name)}?${query}`;
    link.download = name;
    for (const text of [name, WHAT[name] ?? "", size(bytes)]) {
      link.appendChild(document.createElement("span")).textContent = text;
    }
    return link;
  }));
}
