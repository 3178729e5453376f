// The drawing as a table that the page and `subgoal learn` read, made without the server.

export function tableOf({ names, strokes }) {
  const lines = [["time", ...names, "stroke"].map(cell).join(",")];
  for (const [k, stroke] of strokes.entries()) for (const point of stroke) lines.push(`${point.join(",")},stroke ${k + 1}`);
  return `${lines.join("\n")}\n`;
}

const cell = (text) => (/[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
