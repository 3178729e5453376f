// The simulated flight: a quadrotor from the side, tilted as it flies, with its thrust and the trail behind it.

const ARM = 0.17; // metres from hub to rotor, drawn
const LEAST_ARM = 20; // pixels

// Draws the flight as it is at ``now`` (milliseconds); true while it goes on.
export function drawFlight(c, plane, flight, now) {
  flight.begun ??= now;
  const last = flight.times.at(-1);
  const time = plane.calm.matches ? last : Math.min(last, (now - flight.begun) / 1000);
  let i = flight.row ?? 0;
  while (i < flight.times.length - 2 && flight.times[i + 1] <= time) i += 1;
  flight.row = i;
  flight.progress = time / last;
  trail(c, plane, flight, i);
  if (plane.calm.matches) for (let k = 1; k < 6; k++) rotorcraft(c, plane, flight, Math.floor((k * i) / 6), 0, 0.35);
  const span = flight.times[i + 1] - flight.times[i];
  rotorcraft(c, plane, flight, i, span > 0 ? Math.min(1, (time - flight.times[i]) / span) : 0, 1);
  flight.told?.(flight);
  return time < last;
}

// The subgoals in the order in which a flight comes to them, by their numbers on the page.
export function orderOf(flight, plane) {
  const goals = plane.answer.subgoals;
  return flight.stops.map((stop) => {
    const far = goals.map((goal) => Math.hypot(goal.y - stop.y, goal.z - stop.z));
    return { name: plane.slots[far.indexOf(Math.min(...far))] + 1, row: stop.row };
  });
}

function trail(c, plane, flight, until) {
  c.strokeStyle = plane.ink.ink;
  c.globalAlpha = 0.75;
  c.lineWidth = 1.5;
  c.beginPath();
  for (let k = 0; k <= until; k++) c.lineTo(...plane.at([flight.y[k], flight.z[k]]));
  c.stroke();
  c.globalAlpha = 1;
}

function rotorcraft(c, plane, flight, i, part, strength) {
  const between = (values) => values[i] + part * (values[i + 1] - values[i]);
  const [x, y] = plane.at([between(flight.y), between(flight.z)]);
  const arm = Math.max(LEAST_ARM, ARM * plane.scale);
  const thrust = between(flight.thrust);
  c.save();
  c.globalAlpha = strength;
  c.translate(x, y);
  c.rotate(-between(flight.tilt));
  for (const side of [-1, 1]) {
    c.strokeStyle = plane.ink.accent;
    c.globalAlpha = 0.55 * strength;
    c.lineWidth = arm * 0.2;
    c.beginPath();
    c.moveTo(side * arm, arm * 0.12);
    c.lineTo(side * arm, arm * (0.12 + 0.75 * Math.max(0, thrust)));
    c.stroke();
    c.globalAlpha = strength;
    c.strokeStyle = plane.ink.ink;
    c.lineWidth = Math.max(2, arm * 0.08);
    c.beginPath();
    c.moveTo(side * arm, 0);
    c.lineTo(side * arm, -arm * 0.26);
    c.moveTo(side * arm - arm * 0.48, -arm * 0.26);
    c.lineTo(side * arm + arm * 0.48, -arm * 0.26);
    c.stroke();
  }
  c.lineWidth = Math.max(3, arm * 0.12);
  c.beginPath();
  c.moveTo(-arm, 0);
  c.lineTo(arm, 0);
  c.stroke();
  c.fillStyle = plane.ink.ink;
  c.beginPath();
  c.roundRect(-arm * 0.34, -arm * 0.2, arm * 0.68, arm * 0.4, arm * 0.14);
  c.fill();
  c.restore();
}
