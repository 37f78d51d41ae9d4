// Which run the plots of tracks show.
import { chooseTrack, type Track } from "../tracks";

export function TrackChoice({ tracks, shown }: { tracks: Track[]; shown: Track }) {
  if (tracks.length < 2) return null;
  return (
    <label class="track-choice"><span class="quiet">shown</span>{" "}
      <select class="inline" value={shown.name} onChange={(e) => chooseTrack(e.currentTarget.value)}>
        {tracks.map((track) => <option key={track.id} value={track.name}>{track.name}</option>)}
      </select></label>
  );
}
