% Reads a run into Octave or MATLAB. Both list dimensions the other way round than Python does:
% position is 3 x tiles x samples, metres; rotation 4 x tiles x samples, quaternions w x y z.
function run = read_trajectory (file)
  if exist ("h5read")
    run.time = h5read (file, "/time");
    run.position = h5read (file, "/position");
    run.rotation = h5read (file, "/rotation");
    run.target_error = h5read (file, "/measures/target_error");
  else
    found = load ("-hdf5", file, "time", "position", "rotation", "measures");
    run.time = found.time(:);
    run.position = found.position;
    run.rotation = found.rotation;
    run.target_error = found.measures.target_error(:);
  end
end
