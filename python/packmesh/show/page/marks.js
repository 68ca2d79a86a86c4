// What is drawn over the view: directions of the axes, and a scale.

/** Text with a light rim. */
function writeOn(context, text, x, y) {
  context.lineWidth = 3;
  context.strokeStyle = "rgba(255, 255, 255, 0.9)";
  context.strokeText(text, x, y);
  context.fillText(text, x, y);
}

/** Arrows along x, y and z as the camera sees them, those behind first. */
function drawAxes(context, camera, x, y, length) {
  const inverse = camera.matrixWorldInverse.elements;
  const axes = [0, 1, 2].map((k) => ({ name: "xyz"[k], to: [inverse[4 * k], -inverse[4 * k + 1], inverse[4 * k + 2]] }));
  axes.sort((a, b) => a.to[2] - b.to[2]);
  context.font = "600 13px sans-serif";
  Object.assign(context, { textAlign: "center", textBaseline: "middle", lineCap: "round" });
  for (const { name, to } of axes) {
    const [dx, dy] = [length * to[0], length * to[1]], reach = Math.hypot(dx, dy) || 1;
    context.strokeStyle = context.fillStyle = axisColors[name];
    context.lineWidth = 2.5;
    context.beginPath();
    context.moveTo(x, y);
    context.lineTo(x + dx, y + dy);
    context.stroke();
    const tip = Math.min(1, reach / 12);  // arrows towards the eye have no tip
    const [u, v] = [dx / reach, dy / reach];
    context.beginPath();
    context.moveTo(x + dx + 5 * u * tip, y + dy + 5 * v * tip);
    context.lineTo(x + dx - (4 * u + 4 * v) * tip, y + dy - (4 * v - 4 * u) * tip);
    context.lineTo(x + dx - (4 * u - 4 * v) * tip, y + dy - (4 * v + 4 * u) * tip);
    context.fill();
    writeOn(context, name, x + dx + 14 * u, y + dy + 14 * v);
  }
}

/** A bar whose length is right in the middle of the view. @param pixel its size there [µm] */
function drawScale(context, pixel, right, y) {
  const length = roundBelow(130 * pixel), left = right - length / pixel, text = shown(length) + " µm";
  context.strokeStyle = context.fillStyle = "#1d2733";
  context.lineWidth = 2;
  context.lineCap = "butt";
  context.beginPath();
  for (const [x, from] of [[left, y - 5], [right, y - 5]]) {
    context.moveTo(x, from);
    context.lineTo(x, y + 1);
  }
  context.moveTo(left, y);
  context.lineTo(right, y);
  context.stroke();
  context.font = "13px sans-serif";
  Object.assign(context, { textAlign: "center", textBaseline: "alphabetic" });
  writeOn(context, text, (left + right) / 2, y - 8);
  return text;
}

/** Axes and scale at the lower right of a picture of this size. @param distance of the middle of the view from the camera [µm] */
function drawMarks(context, camera, distance, width, height) {
  const pixel = (2 * distance * Math.tan((camera.fov * Math.PI) / 360)) / height;
  drawAxes(context, camera, width - 62, height - 92, 34);
  return drawScale(context, pixel, width - 18, height - 18);
}
