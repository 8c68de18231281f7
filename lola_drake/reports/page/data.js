// What Python has packed (payload.py), as curves again.
async function unpackCurves() {
  const shape = JSON.parse(await unpack(document.getElementById("shape").textContent));
  const packed = document.getElementById("numbers").textContent;
  const bytes = new Uint8Array(await inflated(packed).arrayBuffer());
  const half = bytes.length / 2;
  function values([start, count, low, step]) {
    const out = new Float64Array(count);
    for (let i = 0, whole = 0; i < count; i++) {
      whole = (whole + bytes[start + i] + 256 * bytes[half + start + i]) & 65535;
      out[i] = whole === 65535 ? NaN : low + step * whole;
    }
    return out;
  }
  for (const panel of shape.panels)
    for (const cell of panel.cells)
      for (const curve of cell.curves) {
        const where = { y: curve.y, x: curve.x };
        curve.unpacked = () => {
          if (where.y) {
            curve.y = values(where.y);
            curve.x = where.x && values(where.x);
            where.y = null;
          }
          return curve;
        };
      }
  return shape;
}

// The least and the greatest value of each of many pieces: a screen has no more pixels.
function thinned(curve, start, period, from, to, pieces) {
  const y = curve.y;
  const first = Math.max(Math.floor((from - start) / period) - 1, 0);
  const last = Math.min(Math.ceil((to - start) / period) + 2, y.length);
  const step = Math.max(Math.floor((last - first) / pieces), 1);
  const xs = [], ys = [];
  const put = i => { xs.push(start + i * period); ys.push(isNaN(y[i]) ? null : y[i]); };
  for (let i = first; i < last; i += step) {
    let low = i, high = i;
    for (let k = i + 1; k < Math.min(i + step, last); k++) {
      if (y[k] < y[low] || isNaN(y[low])) low = k;
      if (y[k] > y[high] || isNaN(y[high])) high = k;
    }
    put(Math.min(low, high));
    if (low !== high) put(Math.max(low, high));
  }
  return { x: xs, y: ys };
}
