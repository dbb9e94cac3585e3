"""The paper's search by Python's optimisers: argument 1 the records, argument 2 the names of those to run."""

import cmath
import json
import math
import sys
import time

import numpy as np
from scipy.signal import lfilter

data = json.load(open(sys.argv[1]))
wanted = sys.argv[2].split(",")
dt, kg = data["dt"], data["gear_ratio"]
V, Y = np.array(data["voltage"]), np.array(data["measured"])
Y = Y - Y[:, :1]
I = np.hstack([np.zeros((len(V), 1)), np.cumsum(V, axis=1)[:, :-1] * dt])
centre = np.array(data["centre"])
limit = math.log(data["factor"])
population, generations = data["population"], data["generations"]
evaluations = 0


def iae(genes):
    """theta = G (I - z), z a second-order filter, discretised exactly for a held voltage."""
    global evaluations
    evaluations += 1
    km, kb, l, r, jsh, jr, br, bsh = centre * np.exp(genes)
    j, b = jr * kg * kg + jsh, br * kg * kg + bsh
    a1, a2, a3 = j * l, j * r + b * l, kb * kg * kg * km + b * r
    gain, alpha, beta = kg * km / a3, a2 / a1, a3 / a1
    root = cmath.sqrt(alpha * alpha - 4 * beta)
    p1, p2 = (-alpha + root) / 2, (-alpha - root) / 2
    e1, e2 = cmath.exp(p1 * dt), cmath.exp(p2 * dt)
    g1 = (p1 + alpha) / (p1 - p2) * (e1 - 1) / p1
    g2 = (p2 + alpha) / (p2 - p1) * (e2 - 1) / p2
    z = lfilter([0.0, (g1 + g2).real, (-g1 * e2 - g2 * e1).real], [1.0, -(e1 + e2).real, (e1 * e2).real], V, axis=1)
    return dt * np.abs(gain * (I - z) - Y).sum()


def with_scipy():
    from scipy.optimize import differential_evolution

    result = differential_evolution(
        iae, [(-limit, limit)] * 8, popsize=population // 8, maxiter=generations - 1,
        tol=0, atol=0, polish=False, init="random", seed=1,
    )
    return result.fun


def with_pygad():
    import pygad

    ga = pygad.GA(
        num_generations=generations, sol_per_pop=population, num_parents_mating=population // 2, num_genes=8,
        gene_space={"low": -limit, "high": limit}, init_range_low=-limit, init_range_high=limit,
        fitness_func=lambda ga, genes, k: -iae(genes), keep_elitism=4, parent_selection_type="tournament",
        crossover_type="uniform", crossover_probability=0.8, mutation_probability=0.2, suppress_warnings=True,
        random_seed=1,
    )
    ga.run()
    return -ga.best_solution()[1]


def with_pymoo():
    from pymoo.algorithms.soo.nonconvex.ga import GA
    from pymoo.core.problem import ElementwiseProblem
    from pymoo.optimize import minimize

    class Problem(ElementwiseProblem):
        def __init__(self):
            super().__init__(n_var=8, n_obj=1, xl=-limit, xu=limit)

        def _evaluate(self, x, out, *args, **kwargs):
            out["F"] = iae(x)

    return minimize(Problem(), GA(pop_size=population), ("n_gen", generations), seed=1).F[0]


def with_deap():
    import random

    from deap import algorithms, base, creator, tools

    random.seed(1)
    creator.create("Least", base.Fitness, weights=(-1.0,))
    creator.create("Chromosome", list, fitness=creator.Least)
    box = base.Toolbox()
    box.register("gene", random.uniform, -limit, limit)
    box.register("individual", tools.initRepeat, creator.Chromosome, box.gene, 8)
    box.register("population", tools.initRepeat, list, box.individual)
    box.register("evaluate", lambda genes: (iae(np.clip(genes, -limit, limit)),))
    box.register("mate", tools.cxBlend, alpha=0.25)
    box.register("mutate", tools.mutGaussian, mu=0, sigma=0.2 * limit, indpb=0.25)
    box.register("select", tools.selTournament, tournsize=2)
    best = tools.HallOfFame(1)
    algorithms.eaSimple(box.population(population), box, 0.8, 0.2, generations - 1, halloffame=best, verbose=False)
    return best[0].fitness.values[0]


PEERS = {
    "scipy": ("scipy differential_evolution + lfilter", with_scipy),
    "pygad": ("pygad + lfilter", with_pygad),
    "pymoo": ("pymoo GA + lfilter", with_pymoo),
    "deap": ("DEAP + lfilter", with_deap),
}

for key in wanted:
    name, run = PEERS[key]
    evaluations = 0
    began = time.process_time()
    found = float(run())
    seconds = time.process_time() - began
    print(json.dumps({"name": name, "seconds": seconds, "evaluations": evaluations, "iae": found, "remark": ""}), flush=True)
