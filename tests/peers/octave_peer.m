% The objective as the paper's own software would compute it: lsim on the transfer function. A fraction of the run.
pkg load control
data = jsondecode(fileread(argv(){1}));
evaluations = str2double(argv(){2});
c = num2cell(data.centre); [km, kb, l, r, jsh, jr, br, bsh] = c{:}; kg = data.gear_ratio;
j = jr * kg^2 + jsh; b = br * kg^2 + bsh;
g = tf(kg * km, [j * l, j * r + b * l, kb * kg^2 * km + b * r, 0]);
n = size(data.voltage, 2); t = (0:n - 1)' * data.dt;
began = cputime();
for k = 1:evaluations
  iae = 0;
  for record = 1:3
    y = lsim(g, data.voltage(record, :)', t);
    iae += data.dt * sum(abs(y - (data.measured(record, :) - data.measured(record, 1))'));
  end
end
seconds = cputime() - began;
printf('{"name": "Octave lsim", "seconds": %.6f, "evaluations": %d, "iae": %.6f, "remark": "%d evaluations, extrapolated"}\n', seconds, evaluations, iae, evaluations);
