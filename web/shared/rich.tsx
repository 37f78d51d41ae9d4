// Text with powers of ten, as `format.ts` writes them: "10^−4" with the exponent set higher.
export function Rich({ text }: { text: string }) {
  return (
    <>
      {text.split(/\^([−\d]+)/).map((part, i) => (i % 2 ? <sup key={i}>{part}</sup> : part))}
    </>
  );
}
