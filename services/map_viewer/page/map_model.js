// The map as the page holds it: tiles of cells, and pictures of them: for each block of 8 x 8 tiles a canvas with a pixel
// a cell, and smaller ones for who looks from afar, in which no wall is lost.

import {unpackRuns} from "./wire.js";

const TILE_CELLS = 64;
const BLOCK_TILES = 8;
export const BLOCK_CELLS = TILE_CELLS * BLOCK_TILES;
export const REDUCTIONS = [1, 4, 16];  // cells beside each other that are one pixel
const UNEXPLORED = 127;
const WALL = 90;  // as map_server takes it: bytes below are occupied

// 256 colours, by what a cell's byte is: 255 free .. 0 occupied. free, wall: red, green, blue; least: how much is seen of
// what is hardly known, and free_share of what is free, 0 to 1.
export function makePalette(free, wall, {least = 0.25, free_share = 1} = {}) {
  const palette = new Uint32Array(256);
  const bytes = new Uint8Array(palette.buffer);
  for (let value = 0; value < 256; ++value) {
    if (value === UNEXPLORED) continue;
    const is_free = value > UNEXPLORED;
    const [colour, share] = is_free ? [free, (value - UNEXPLORED) / 128] : [wall, (UNEXPLORED - value) / 127];
    bytes.set(colour, 4 * value);
    bytes[4 * value + 3] = Math.round(255 * Math.min(1, least + (1 - least) * share) * (is_free ? free_share : 1));
  }
  return palette;
}

// Every cell as its byte says it, as in map.png.
const GREY = Uint32Array.from({length: 256}, (_, value) => (0xff000000 | (value << 16) | (value << 8) | value) >>> 0);

export class MapModel {
  constructor() {
    this.cell_size_m = 0.05;
    this.palette = GREY;
    this.clear();
  }

  clear() {
    this.tiles = new Map();   // "x,y": {x, y, cells}
    this.blocks = new Map();  // "x,y": {x, y, pictures}, made when drawn
    this.stale = new Set();   // tiles whose picture is old
    this.num_explored = 0;    // cells
  }

  setPalette(palette) {
    this.palette = palette;
    for (const key of this.tiles.keys()) this.stale.add(key);
  }

  take({x, y, whole, runs}) {
    const key = `${x},${y}`;
    let tile = this.tiles.get(key);
    if (!tile) {
      tile = {x, y, cells: new Uint8Array(TILE_CELLS * TILE_CELLS).fill(UNEXPLORED), num_explored: 0};
      this.tiles.set(key, tile);
    } else if (whole) {
      tile.cells.fill(UNEXPLORED);
    }
    unpackRuns(runs, tile.cells);
    const num_explored = tile.cells.reduce((sum, cell) => sum + (cell !== UNEXPLORED), 0);
    this.num_explored += num_explored - tile.num_explored;
    tile.num_explored = num_explored;
    this.stale.add(key);
  }

  // The byte of the cell that holds a point.
  at(x_m, y_m) {
    const x = Math.floor(x_m / this.cell_size_m);
    const y = Math.floor(y_m / this.cell_size_m);
    const tile = this.tiles.get(`${x >> 6},${y >> 6}`);
    return tile ? tile.cells[((y & 63) << 6) | (x & 63)] : UNEXPLORED;
  }

  // What a ray hits that ends there: "wall", "free" or "new". A wall may be a cell beside it.
  hit(x_m, y_m) {
    const size = this.cell_size_m;
    for (const [dx, dy] of [[0, 0], [size, 0], [-size, 0], [0, size], [0, -size]]) {
      if (this.at(x_m + dx, y_m + dy) < UNEXPLORED) return "wall";
    }
    return this.at(x_m, y_m) > UNEXPLORED ? "free" : "new";
  }

  // Explored rectangle [m]; null while nothing is.
  extent() {
    const size = TILE_CELLS * this.cell_size_m;
    let extent = null;
    for (const {x, y, num_explored} of this.tiles.values()) {
      if (num_explored === 0) continue;  // of a piece that was shown before
      const {x0, y0, x1, y1} = extent ?? {x0: Infinity, y0: Infinity, x1: -Infinity, y1: -Infinity};
      extent = {x0: Math.min(x0, x * size), y0: Math.min(y0, y * size), x1: Math.max(x1, (x + 1) * size), y1: Math.max(y1, (y + 1) * size)};
    }
    return extent;
  }

  area_m2() { return this.num_explored * this.cell_size_m ** 2; }

  // Brings the pictures up to date. A picture's first row is the block's highest.
  paint() {
    for (const key of this.stale) {
      const tile = this.tiles.get(key);
      const block = this.block(Math.floor(tile.x / BLOCK_TILES), Math.floor(tile.y / BLOCK_TILES));
      let cells = tile.cells;
      REDUCTIONS.forEach((reduction, level) => {
        const side = TILE_CELLS / reduction;
        if (level > 0) cells = reduce(cells, (side * reduction) / REDUCTIONS[level - 1], reduction / REDUCTIONS[level - 1]);
        const column = (tile.x - block.x * BLOCK_TILES) * side;
        const row = (BLOCK_TILES - 1 - (tile.y - block.y * BLOCK_TILES)) * side;
        block.pictures[level].getContext("2d").putImageData(paintCells(cells, side, this.palette), column, row);
      });
    }
    this.stale.clear();
  }

  block(x, y) {
    const key = `${x},${y}`;
    let block = this.blocks.get(key);
    if (!block) {
      block = {x, y, pictures: REDUCTIONS.map((reduction) => {
        const canvas = document.createElement("canvas");
        canvas.width = canvas.height = BLOCK_CELLS / reduction;
        return canvas;
      })};
      this.blocks.set(key, block);
    }
    return block;
  }

  // The map alone, a pixel a cell, with the bytes of map.png; its explored rectangle, too.
  toCanvas() {
    const {x0, y0, x1, y1} = this.exploredCells();
    const canvas = document.createElement("canvas");
    canvas.width = x1 - x0 + 1;
    canvas.height = y1 - y0 + 1;
    const context = canvas.getContext("2d");
    context.fillStyle = `rgb(${UNEXPLORED}, ${UNEXPLORED}, ${UNEXPLORED})`;
    context.fillRect(0, 0, canvas.width, canvas.height);
    for (const tile of this.tiles.values()) {
      context.putImageData(paintCells(tile.cells, TILE_CELLS, GREY), tile.x * TILE_CELLS - x0,
                           y1 + 1 - (tile.y + 1) * TILE_CELLS);
    }
    return canvas;
  }

  exploredCells() {
    const box = {x0: Infinity, y0: Infinity, x1: -Infinity, y1: -Infinity};
    for (const tile of this.tiles.values()) {
      tile.cells.forEach((cell, index) => {
        if (cell === UNEXPLORED) return;
        const x = tile.x * TILE_CELLS + (index & 63);
        const y = tile.y * TILE_CELLS + (index >> 6);
        box.x0 = Math.min(box.x0, x);
        box.y0 = Math.min(box.y0, y);
        box.x1 = Math.max(box.x1, x);
        box.y1 = Math.max(box.y1, y);
      });
    }
    return this.num_explored > 0 ? box : {x0: 0, y0: 0, x1: 0, y1: 0};
  }
}

const images = new Map(REDUCTIONS.map((reduction) => {
  const side = TILE_CELLS / reduction;
  return [side, new ImageData(side, side)];
}));

// The picture of side x side cells, the highest row first.
function paintCells(cells, side, palette) {
  const image = images.get(side);
  const pixels = new Uint32Array(image.data.buffer);
  for (let row = 0; row < side; ++row) {
    const from = (side - 1 - row) * side;
    for (let column = 0; column < side; ++column) pixels[row * side + column] = palette[cells[from + column]];
  }
  return image;
}

// One cell for each square of `factor` cells on a side: its wall if it has one, else what is most surely free.
function reduce(cells, side, factor) {
  const small = side / factor;
  const reduced = new Uint8Array(small * small);
  for (let y = 0; y < small; ++y) {
    for (let x = 0; x < small; ++x) {
      let [wall, free] = [UNEXPLORED, UNEXPLORED];
      for (let dy = 0; dy < factor; ++dy) {
        for (let dx = 0; dx < factor; ++dx) {
          const cell = cells[(y * factor + dy) * side + x * factor + dx];
          if (cell < wall) wall = cell; else if (cell > free) free = cell;
        }
      }
      reduced[y * small + x] = wall < WALL ? wall : free;
    }
  }
  return reduced;
}

// Cells of walls, as x, y, x, y, ... in cells; of very many, every so many.
function findWallCells(map) {
  const MOST = 20000;
  const found = [];
  for (const {x: tile_x, y: tile_y, cells} of map.tiles.values()) {
    for (let at = 0; at < cells.length; ++at) {
      if (cells[at] < WALL) found.push(tile_x * TILE_CELLS + (at % TILE_CELLS), tile_y * TILE_CELLS + Math.floor(at / TILE_CELLS));
    }
  }
  const step = Math.ceil(found.length / 2 / MOST);
  return step > 1 ? found.filter((_, i) => Math.floor(i / 2) % step === 0) : found;
}

// The direction of the walls [rad], within an eighth of a turn: seen along it, most cells of walls lie behind each other.
export function findWalls(map) {
  const cells = findWallCells(map);
  if (cells.length === 0) return 0;
  const furthest = Math.ceil(Math.SQRT2 * cells.reduce((most, cell) => Math.max(most, Math.abs(cell)), 0)) + 1;
  const counts = new Uint32Array(2 * furthest + 1);
  const sharpness = (degrees) => {
    const [cos, sin] = [Math.cos(degrees * Math.PI / 180), Math.sin(degrees * Math.PI / 180)];
    let sum = 0;
    for (const [along, across] of [[cos, sin], [-sin, cos]]) {
      counts.fill(0);
      for (let i = 0; i < cells.length; i += 2) sum += 2 * counts[furthest + Math.round(along * cells[i] + across * cells[i + 1])]++ + 1;
    }
    return sum;
  };
  let best = {degrees: 0, sharpness: sharpness(0)};
  for (const [reach, step] of [[45, 1], [1, 0.1], [0.1, 0.02]]) {
    const middle = best.degrees;
    for (let degrees = middle - reach; degrees <= middle + reach; degrees += step) {
      const here = {degrees, sharpness: sharpness(degrees)};
      if (here.sharpness > best.sharpness) best = here;
    }
  }
  return best.degrees * Math.PI / 180;
}
