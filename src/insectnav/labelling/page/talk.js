// Talk with the program; bytes go packed both ways.

export async function ask(place, options) {
  let answer;
  try {
    answer = await fetch(place, options);
  } catch {
    throw new Error("the program does not answer: was it ended?");
  }
  if (!answer.ok) throw new Error((await answer.json().catch(() => ({}))).error ?? `the program answers ${answer.status}`);
  return answer;
}

export async function packed(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new CompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

export async function unpacked(buffer) {
  const stream = new Blob([buffer]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
